"use strict";

const data = JSON.parse(document.getElementById("report-data").textContent);
const KINDS = { f4: Float32Array, u2: Uint16Array, u4: Uint32Array, i2: Int16Array };
const COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f",
  "#bcbd22", "#17becf", "#393b79", "#637939", "#111111"];
const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["sendDataToCloud", "lasso2d", "select2d"] };

/* m beyond the middles of the outer shoes that rollers are drawn */
const ROLLERS_BESIDE = 0.75;

function unpack(text, kind) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new KINDS[kind](bytes.buffer);
}

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "onchange" || key === "onclick") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/* pixels of numbers and title of the time below a plot */
const TIME_TITLE = 50;

/* time histories: one object a plot, which owns its controls */

class SeriesPlot {
  constructor(place, first) {
    this.caseNames = Object.keys(data.cases);
    this.case = this.caseNames[0];
    this.cache = new Map();
    this.names = [];
    this.legendBelow = 0;
    this.caseSelect = element("select", { "aria-label": "case", onchange: () => this.pickCase(this.caseSelect.value) },
      ...this.caseNames.map((name) => element("option", { value: name }, name)));
    this.quantitySelect = element("select", { "aria-label": "quantity", onchange: () => this.pickQuantity() });
    this.axisBox = element("fieldset", { class: "axes" });
    this.itemBox = element("fieldset", { class: "items" });
    this.figure = element("div", { class: "figure" });
    const controls = element("div", { class: "controls" });
    if (this.caseNames.length > 1) controls.append(this.caseSelect);
    controls.append(this.quantitySelect, this.axisBox, this.itemBox);
    place.append(controls, this.figure);
    this.pickCase(this.case, first);
    this.figure.on("plotly_relayout", () => this.namePhases());
  }

  pickCase(name, label = null) {
    label = label ?? this.quantity?.label;
    this.case = name;
    const quantities = data.cases[name].quantities;
    this.quantitySelect.replaceChildren();
    let group = null;
    quantities.forEach((quantity, index) => {
      if (!group || group.label !== quantity.group) {
        group = element("optgroup", { label: quantity.group });
        this.quantitySelect.append(group);
      }
      group.append(element("option", { value: index }, `${quantity.label} in ${quantity.unit}`));
    });
    const index = quantities.findIndex((quantity) => quantity.label === label);
    this.quantitySelect.value = String(Math.max(index, 0));
    this.pickQuantity();
  }

  pickQuantity() {
    const before = this.quantity;
    this.quantity = data.cases[this.case].quantities[Number(this.quantitySelect.value)];
    const same = (name) => before && JSON.stringify(before[name]) === JSON.stringify(this.quantity[name]);
    if (!same("items")) this.fillItems();
    if (!same("axes")) this.fillAxes();
    this.draw();
  }

  fillAxes() {
    this.axisBox.replaceChildren(element("legend", {}, "axes"));
    this.axisBox.hidden = this.quantity.axes.length < 2;
    for (const axis of this.quantity.axes) this.axisBox.append(this.box(axis, axis, true));
  }

  fillItems() {
    const items = this.quantity.items;
    const shown = (item) => items.length <= 7 || this.quantity.drawn.includes(Number(item.match(/\d+/)?.[0]));
    const all = (checked) => {
      for (const box of this.itemBox.querySelectorAll("input")) box.checked = checked;
      this.draw();
    };
    this.itemBox.replaceChildren(element("legend", {}, items[0].split(" ")[0] + "s"));
    this.itemBox.hidden = items.length < 2;
    for (const item of items) this.itemBox.append(this.box(item, item.split(" ").slice(1).join(" "), shown(item)));
    this.itemBox.append(
      element("button", { type: "button", onclick: () => all(true) }, "all"),
      element("button", { type: "button", onclick: () => all(false) }, "none"));
  }

  box(value, label, checked) {
    const input = element("input", { type: "checkbox", value, onchange: () => this.draw() });
    input.checked = checked;
    return element("label", {}, input, " ", label);
  }

  picked(box) {
    return [...box.querySelectorAll("input:checked")].map((input) => input.value);
  }

  series(item, axis) {
    const key = [this.case, this.quantity.label, item, axis].join("|");
    if (!this.cache.has(key)) {
      const time = unpack(data.cases[this.case].times[this.quantity.time], "f4");
      const [index, values] = this.quantity.series[item][axis];
      this.cache.set(key, {
        x: Float32Array.from(unpack(index, this.quantity.index), (k) => time[k]),
        y: unpack(values, "f4"),
      });
    }
    return this.cache.get(key);
  }

  draw() {
    const { items, axes, label, unit, floor } = this.quantity;
    const chosenAxes = axes.length < 2 ? axes : this.picked(this.axisBox);
    const chosenItems = items.length < 2 ? items : this.picked(this.itemBox);
    const traces = [];
    const panels = 20 + 230 * Math.max(chosenAxes.length, 1);
    const top = TOUCHED.matches ? TOOLBAR + 16 : 20, below = TIME_TITLE + this.legendBelow;
    const layout = {
      height: panels + top + below,
      margin: { ...(NARROW.matches ? { l: 74, r: 6, autoexpand: false } : { l: 80, r: 20 }), t: top, b: below },
      grid: { rows: Math.max(chosenAxes.length, 1), columns: 1, pattern: "coupled" },
      xaxis: { title: { text: "time in s" } },
      legend: NARROW.matches ? { orientation: "h", y: -TIME_TITLE / panels, yanchor: "top", tracegroupgap: 0 } : { tracegroupgap: 0 },
      shapes: phaseBands(data.cases[this.case].phases),
      annotations: this.names,
      showlegend: chosenItems.length > 1,
      hovermode: "x",
      uirevision: `${this.case}|${label}|${chosenAxes}`,
    };
    chosenAxes.forEach((axis, row) => {
      const name = row === 0 ? "yaxis" : `yaxis${row + 1}`;
      layout[name] = { title: { text: `${axis} ${label}<br>in ${unit}`.trim(), font: { size: 12 } }, exponentformat: "power" };
      const drawn = chosenItems.map((item) => this.series(items.indexOf(item), axes.indexOf(axis)));
      // rounding must not look like motion
      if (drawn.every(({ y }) => y.every((value) => Math.abs(value) < floor))) layout[name].range = [-floor, floor];
      chosenItems.forEach((item, k) => {
        const number = items.indexOf(item);
        traces.push({
          ...drawn[k],
          type: "scatter", mode: "lines", name: item, legendgroup: item, showlegend: row === 0,
          line: { width: 1.2, color: COLOURS[number % COLOURS.length] },
          xaxis: "x", yaxis: row === 0 ? "y" : `y${row + 1}`,
          hovertemplate: `%{y:.4g} ${unit}`,
        });
      });
    });
    Plotly.react(this.figure, traces, layout, CONFIG);
    const { legend } = this.figure._fullLayout;
    const legendBelow = NARROW.matches && layout.showlegend ? Math.ceil(legend._height) : 0;
    if (legendBelow !== this.legendBelow) {
      this.legendBelow = legendBelow;
      this.draw();
      return;
    }
    this.namePhases();
  }

  /* those that have room where the time is zoomed as it is */
  namePhases() {
    const names = phaseNames(data.cases[this.case].phases, this.figure._fullLayout.xaxis);
    if (JSON.stringify(names) === JSON.stringify(this.names)) return;
    this.names = names;
    Plotly.relayout(this.figure, { annotations: names });
  }
}

/* flexible shoes */

const SHOE_CAMERA = { eye: { x: -1.5, y: -1.3, z: 1.1 }, up: { x: 0, y: 0, z: 1 }, center: { x: 0, y: 0, z: -0.2 } };

class ShoeView {
  constructor(place, shoes) {
    this.place = place;
    this.shoes = shoes;
    this.position = unpack(shoes.position, "f4");
    this.triangle = unpack(shoes.triangle, "u4");
    this.corner = [0, 1, 2].map((k) => this.triangle.filter((_, index) => index % 3 === k));
    const control = (id) => document.getElementById(id);
    this.time = control("shoe-time");
    this.bend = control("shoe-bend");
    this.gap = control("shoe-gap");
    this.limit = control("shoe-limit");
    this.forces = control("shoe-forces");
    this.trust = control("shoe-trust");
    this.trust.parentElement.hidden = shoes.verdict.length === 0;
    this.rolling = control("shoe-rollers");
    this.rolling.parentElement.hidden = !shoes.undercarriage;
    this.shown = control("shoe-time-shown");
    this.time.max = shoes.frames.length - 1;
    this.time.value = shoes.first;
    this.bend.value = shoes.magnification;
    this.limit.value = shoes.limit;
    const inputs = [this.time, this.bend, this.gap, this.limit, this.forces, this.rolling, this.trust];
    for (const input of inputs) input.oninput = () => this.draw();
    this.draw();
  }

  /* m along x by which a shoe is drawn away from its place */
  shift(index) {
    const { shoes } = this.shoes;
    return Number(this.gap.value) * (shoes[index] - 0.5 * (shoes[0] + shoes[shoes.length - 1]));
  }

  surface(frame, index) {
    const { bend_step: step, mises_step: misesStep, shoes } = this.shoes;
    const bend = unpack(frame.bend[index], "i2");
    const mises = unpack(frame.mises[index], "u2");
    const origin = [frame.origin[index][0] + this.shift(index), ...frame.origin[index].slice(1)];
    const turn = frame.frame[index];
    const factor = Number(this.bend.value) * step;
    const bent = this.position.map((value, index) => value + factor * bend[index]);
    const place = placed(bent, origin, turn);
    const stress = Float32Array.from(mises, (value) => misesStep * value);
    return {
      type: "mesh3d", name: `shoe ${shoes[index]}: ${frame.highest[index].toFixed(1)} MPa`,
      x: place[0], y: place[1], z: place[2], i: this.corner[0], j: this.corner[1], k: this.corner[2],
      ...this.colours(stress, index), colorscale: data.colours, showscale: index === 0, showlegend: true,
      flatshading: true, lighting: { ambient: 0.75, diffuse: 0.45, specular: 0, fresnel: 0, facenormalsepsilon: 0 },
      lightposition: { x: -30000, y: -60000, z: 90000 },
      hoverinfo: "text",
    };
  }

  /* what colours a shoe's nodes and what they say: the stress in MPa, or the verdict on the greatest of each */
  colours(stress, index) {
    const name = `shoe ${this.shoes.shoes[index]}`;
    const bar = { x: 0, xanchor: "left", len: 0.8 };
    if (!this.trust.checked) {
      const colorbar = this.barLies() ? lyingBar(this.place, "von Mises in MPa") : { title: { text: "von Mises<br>in MPa" }, ...bar };
      return {
        intensity: stress, cmin: 0, cmax: Number(this.limit.value) || this.shoes.limit,
        colorbar,
        text: Array.from(stress, (value) => `${name}: ${value.toFixed(1)} MPa`),
      };
    }
    const words = this.shoes.verdicts;
    const numbers = Array.from(unpack(this.shoes.verdict[index], "i2"));
    return {
      intensity: numbers.map((number) => (number < 0 ? NaN : number)), cmin: 0, cmax: words.length - 1,
      colorbar: { title: { text: "greatest stress" }, tickvals: words.map((_, k) => k), ticktext: words, ...bar },
      text: numbers.map((number) => `${name}: ${words[number] ?? "not known, the drive pulls here"}`),
    };
  }

  /* beside a narrow view a bar would hide shoes; the verdicts' words have no room below one */
  barLies() {
    return NARROW.matches && !this.trust.checked;
  }

  /* least and greatest coordinates (m) of all that is drawn, and a margin */
  ranges(traces) {
    return ["x", "y", "z"].map((axis) => {
      let low = Infinity, high = -Infinity;
      for (const trace of traces) {
        for (const value of trace[axis]) {
          if (value === null) continue;
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
      }
      const margin = (high - low) / 32;
      return [low - margin, high + margin];
    });
  }

  /* forces of ground and rollers */
  acting(frame) {
    const shifted = frame.points.map((packed, index) =>
      unpack(packed, "f4").map((value, at) => value + (at % 3 === 0 ? this.shift(index) : 0)));
    const all = (parts) => Float32Array.from(parts.flatMap((part) => [...part]));
    const forces = all(frame.forces.map((packed) => unpack(packed, "f4")));
    return arrows(all(shifted), forces, this.shoes.force_scale, data.arrows, "contact forces");
  }

  /* rollers above the shoes, where these stand in their places */
  rollers(frame) {
    const { undercarriage: shape } = this.shoes;
    if (!shape || !this.rolling.checked || Number(this.gap.value) !== 0) return [];
    const places = frame.origin.map(([x]) => x);
    const near = (x) => x > Math.min(...places) - ROLLERS_BESIDE && x < Math.max(...places) + ROLLERS_BESIDE;
    return [{ ...rollerSurface(shape, frame.side_frame, shape.colour, near), opacity: 0.45 }];
  }

  draw() {
    const frame = this.shoes.frames[Number(this.time.value)];
    this.shown.textContent = frame.title;
    const traces = this.shoes.shoes.map((_, index) => this.surface(frame, index));
    if (this.forces.checked) traces.push(...this.acting(frame));
    traces.push(...this.rollers(frame));
    const ranges = this.ranges(traces);
    const spans = ranges.map(([low, high]) => high - low);
    // the camera counts on a box of a volume of one
    const aspect = spans.map((span) => span / Math.cbrt(spans[0] * spans[1] * spans[2]));
    const layout = viewLayout(this.place, ranges, aspect, SHOE_CAMERA, "shoes", this.barLies());
    Plotly.react(this.place, traces, layout, CONFIG);
  }
}

/* the rest of the page */

function showPictures() {
  const figures = [...document.querySelectorAll("figure.picture")];
  const buttons = [...document.querySelectorAll("#picture-buttons button")];
  const show = (chosen) => {
    figures.forEach((figure, index) => { figure.style.display = index === chosen ? "" : "none"; });
    buttons.forEach((button, index) => button.setAttribute("aria-pressed", String(index === chosen)));
  };
  buttons.forEach((button, index) => { button.onclick = () => show(index); });
  if (figures.length) show(data.first_picture);
}

function filterComparison() {
  for (const radio of document.querySelectorAll("#comparison-filter input")) {
    radio.onchange = () => {
      for (const row of document.querySelectorAll("#comparison-table tbody tr")) {
        row.hidden = radio.value !== "all" && !row.classList.contains(radio.value);
      }
    };
  }
}

const report = { plots: [], shoes: null, track: null };
if (Object.keys(data.cases).length) {
  report.plots = data.first.map((label, index) => new SeriesPlot(document.getElementById(`plot-${index}`), label));
}
if (Object.keys(data.tracks).length) {
  // a 3D view costs a second to draw: not before it is seen
  const place = document.getElementById("track-view");
  const watcher = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    watcher.disconnect();
    report.track = new TrackView(place, data.tracks);
  });
  watcher.observe(place);
}
if (data.shoes) report.shoes = new ShoeView(document.getElementById("shoe-view"), data.shoes);
let width = window.innerWidth;
window.addEventListener("resize", () => {
  // phones change the height of a page whenever it is scrolled
  if (window.innerWidth === width) return;
  width = window.innerWidth;
  for (const one of [...report.plots, report.track, report.shoes]) one?.draw();
});
showPictures();
filterComparison();
document.body.dataset.ready = "yes";

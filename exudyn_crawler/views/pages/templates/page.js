const COLOURS = ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f",
  "#bcbd22", "#17becf", "#393b79", "#637939", "#111111"];

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
      const shown = data.cases[this.case], time = unpack(shown.time, "f4");
      const [index, values] = this.quantity.series[item][axis];
      this.cache.set(key, {
        x: Float32Array.from(unpack(index, shown.index), (k) => time[k]),
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

const report = { plots: [], views: {} };
if (data.first) {
  report.plots = data.first.map((label, index) => new SeriesPlot(document.getElementById(`plot-${index}`), label));
}
for (const [name, scenes] of Object.entries(data.scenes)) {
  // a 3D view costs a second to draw: not before it is seen
  const watcher = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    watcher.disconnect();
    report.views[name] ??= new SceneView(name, scenes);
  });
  watcher.observe(document.getElementById(`${name}-view`).closest("section"));
}
let width = window.innerWidth;
window.addEventListener("resize", () => {
  // phones change the height of a page whenever it is scrolled
  if (window.innerWidth === width) return;
  width = window.innerWidth;
  for (const one of [...report.plots, ...Object.values(report.views)]) one.draw();
});
showPictures();
filterComparison();
document.body.dataset.ready = "yes";

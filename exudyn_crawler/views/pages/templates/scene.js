/* views of scenes in 3D: solids with their places over time, colours and arrows, as Python packs them */

const BOX_SHADE = { ambient: 0.75, diffuse: 0.45, specular: 0, fresnel: 0, facenormalsepsilon: 0 };
const LIGHT = { x: -30000, y: -60000, z: 90000 };

/* directions from which views look, and what is upward in them */
const CAMERAS = {
  isometric: { eye: { x: -0.7, y: -1.45, z: 0.85 }, up: { x: 0, y: 0, z: 1 } },
  above: { eye: { x: 0, y: 0, z: 1 }, up: { x: 0, y: 1, z: 0 } },
  side: { eye: { x: 0, y: -1, z: 0 }, up: { x: 0, y: 0, z: 1 } },
  behind: { eye: { x: -1.5, y: -1.3, z: 1.3 }, up: { x: 0, y: 0, z: 1 } },
};

const unpacked = new Map();

/* array of the page's data by its number, unpacked once, as numbers of its own unit */
function array(number) {
  if (!unpacked.has(number)) {
    const { kind, data: text, step } = data.arrays[number];
    const values = unpack(text, kind);
    unpacked.set(number, step === undefined ? values : Float32Array.from(values, (value) => step * value));
  }
  return unpacked.get(number);
}

/* part of an array that belongs to one of the times; arrays of what never changes have one row */
function row(number, time) {
  const values = array(number);
  const { rows } = data.arrays[number];
  const size = values.length / rows;
  const at = rows > 1 ? time : 0;
  return values.subarray(size * at, size * (at + 1));
}

/* copies of a solid that are there at a time */
function copiesThere(solid, time) {
  const origin = row(solid.origin, time);
  return [...Array(origin.length / 3).keys()].filter((copy) => !Number.isNaN(origin[3 * copy]));
}

/* nodes [x, y, z] and triangles [i, j, k] of all copies of a solid at a time */
function solidMesh(solid, time, larger = solid.larger, shift = 0) {
  const points = array(solid.points), triangles = array(solid.triangles), count = points.length / 3;
  const origin = row(solid.origin, time), turn = row(solid.turn, time);
  const lift = solid.lift === null ? null : row(solid.lift, time);
  const bend = solid.bend === null ? null : row(solid.bend, time);
  const there = copiesThere(solid, time);
  const nodes = [0, 1, 2].map(() => new Float32Array(count * there.length));
  there.forEach((copy, place) => {
    for (let point = 0; point < count; point++) {
      const bent = [0, 1, 2].map((axis) =>
        points[3 * point + axis] + (bend === null ? 0 : larger * bend[3 * (count * copy + point) + axis]));
      for (let axis = 0; axis < 3; axis++) {
        const along = 9 * copy + 3 * axis;
        nodes[axis][count * place + point] = origin[3 * copy + axis]
          + turn[along] * bent[0] + turn[along + 1] * bent[1] + turn[along + 2] * bent[2];
      }
      nodes[0][count * place + point] += shift;
      if (lift !== null) nodes[2][count * place + point] += lift[copy];
    }
  });
  const corners = [0, 1, 2].map((corner) => {
    const own = triangles.filter((_, index) => index % 3 === corner);
    return Uint32Array.from({ length: own.length * there.length }, (_, index) =>
      own[index % own.length] + count * Math.floor(index / own.length));
  });
  return { nodes, corners, there, count };
}

/* value of a colouring for reading */
function said(colouring, value) {
  if (colouring.words.length) return colouring.words[value] ?? "not known, the drive pulls here";
  const unit = colouring.title.split(" in ")[1];
  if (Number.isNaN(value)) return "not known, the drive pulls here";
  if (!colouring.decades) return `${value.toFixed(1)} ${unit}`;
  return `${value >= colouring.high ? `beyond 1e${colouring.high}` : Number((10 ** value).toPrecision(4))} ${unit}`;
}

/* what a reader sees over each node of a solid: whose it is, and all that is known there */
function hovered(solid, time, chosen, { there, count }) {
  const numbers = solid.nodes === null ? null : array(solid.nodes);
  const told = [chosen, ...solid.colourings.filter((one) => one !== chosen && one.words.length)]
    .filter((one) => one && one.nodal).map((one) => [one, row(one.values, time)]);
  return there.flatMap((copy) => Array.from({ length: count }, (_, point) => {
    const name = [solid.labels[copy], numbers && `node ${numbers[point]}`].filter(Boolean).join(", ");
    const values = told.map(([one, values]) => said(one, values[count * copy + point]));
    return values.length ? `${name}: ${values.join("; ")}` : name;
  }));
}

/* colours of a solid: of one value a node, a copy, or a face; verdicts are not mixed within a face */
function coloured(solid, time, colouring, high, { corners, there, count }) {
  const values = row(colouring.values, time);
  const shown = { cmin: colouring.low, cmax: high, colorscale: colouring.colours };
  if (!colouring.nodal) {
    const faces = corners[0].length / there.length;
    const each = Float32Array.from({ length: corners[0].length }, (_, face) => values[there[Math.floor(face / faces)]]);
    return { ...shown, intensity: each, intensitymode: "cell" };
  }
  const nodal = Float32Array.from({ length: count * there.length }, (_, at) => values[count * there[Math.floor(at / count)] + at % count]);
  if (!colouring.words.length) return { ...shown, intensity: nodal };
  const low = colouring.words.length - 1;
  const worst = Float32Array.from(corners[0], (_, face) => corners
    .map((one) => nodal[one[face]])
    .reduce((a, b) => (Number.isNaN(a) || a === low ? b : Number.isNaN(b) || b === low ? a : Math.max(a, b))));
  return { ...shown, intensity: worst, intensitymode: "cell" };
}

/* forces (flat, N) that act at heads (flat, m): lines with heads there, and again beyond what they act on, along their
   lines, since that hides one or the other; those at no place are left out */
function arrows({ name, colour, scale, through, heads: places, forces: pushes }, time, shift = 0) {
  const points = row(places, time), forces = row(pushes, time);
  const lines = { x: [], y: [], z: [] };
  const heads = { x: [], y: [], z: [], u: [], v: [], w: [] };
  let longest = 0;
  for (let at = 0; at < points.length; at += 3) {
    const length = Math.hypot(forces[at], forces[at + 1], forces[at + 2]);
    if (!(length > 0) || Number.isNaN(points[at])) continue;
    longest = Math.max(longest, scale * length);
    const beyond = through ? [0, through / length + scale] : [0];
    for (const further of beyond) {
      ["x", "y", "z"].forEach((axis, k) => {
        const head = points[at + k] + further * forces[at + k] + (k === 0 ? shift : 0);
        lines[axis].push(head - scale * forces[at + k], head, null);
        heads[axis].push(head);
        heads["uvw"[k]].push(forces[at + k] / length);
      });
    }
  }
  return [
    { ...lines, type: "scatter3d", mode: "lines", line: { color: colour, width: 5 }, name, hoverinfo: "skip", showlegend: false },
    { ...heads, type: "cone", anchor: "tip", sizemode: "absolute", sizeref: 0.05 + 0.25 * longest, showscale: false,
      colorscale: [[0, colour], [1, colour]], lighting: { ambient: 0.9, diffuse: 0.2 }, name, hoverinfo: "skip", showlegend: false },
  ];
}

/* one view, with whatever controls of it the page has: elements named after it and what they are for */
class SceneView {
  constructor(name, scenes) {
    this.place = document.getElementById(`${name}-view`);
    this.scenes = scenes;
    this.control = Object.fromEntries(
      ["case", "time", "time-shown", "play", "bend", "gap", "limit", "colouring", "forces", "ground", "rollers"]
        .map((use) => [use, document.getElementById(`${name}-${use}`)]));
    this.camera = this.place.dataset.from;
    this.looks = 0;
    const names = Object.keys(scenes);
    const { case: cases, play } = this.control;
    if (cases) {
      cases.replaceChildren(...names.map((one) => element("option", { value: one }, one)));
      cases.hidden = names.length < 2;
      cases.onchange = () => this.pick(cases.value);
    }
    if (play) play.onclick = () => this.play(!this.playing);
    for (const button of this.place.parentElement.querySelectorAll("[data-camera]")) {
      button.onclick = () => this.look(button.dataset.camera);
    }
    for (const use of ["time", "bend", "gap", "limit", "colouring", "forces", "ground", "rollers"]) {
      if (this.control[use]) this.control[use].oninput = () => this.draw();
    }
    this.pick(names[0]);
  }

  pick(name) {
    const scene = this.scene = this.scenes[name];
    const { time, bend, limit, colouring, rollers } = this.control;
    const [first] = scene.solids;
    if (time) [time.max, time.value] = [scene.titles.length - 1, scene.first];
    if (bend) bend.value = first.larger;
    if (limit) limit.value = first.colourings[0].high;
    if (colouring) {
      colouring.replaceChildren(...first.colourings.map((one) => element("option", { value: one.name }, one.name)));
      colouring.parentElement.hidden = first.colourings.length < 2;
    }
    if (rollers) rollers.parentElement.hidden = !scene.solids.some((one) => one.name === "rollers");
    this.draw();
  }

  /* from a named side, wherever the reader has turned the view */
  look(name) {
    this.camera = name;
    this.looks += 1;
    this.draw();
  }

  now() {
    return this.control.time ? Number(this.control.time.value) : 0;
  }

  isShown(use) {
    return this.control[use]?.checked ?? true;
  }

  /* m along x by which a solid is drawn away from its place, by the number in its name */
  shift(name) {
    const apart = Number(this.control.gap?.value ?? 0);
    if (!apart) return 0;
    const numbers = this.scene.solids.map((one) => Number(one.name.match(/\d+/)?.[0])).filter(Number.isFinite);
    return apart * (Number(name.match(/\d+/)) - 0.5 * (numbers[0] + numbers[numbers.length - 1]));
  }

  /* colouring of a solid that is chosen, and the value at the end of its colours */
  chosen(solid) {
    const colouring = solid.colourings.find((one) => one.name === this.control.colouring?.value) ?? solid.colourings[0];
    const limited = this.control.limit && colouring === solid.colourings[0];
    return [colouring, (limited && Number(this.control.limit.value)) || colouring?.high];
  }

  solid(solid, hasBar) {
    const time = this.now(), { bend } = this.control;
    const mesh = solidMesh(solid, time, bend ? Number(bend.value) : solid.larger, this.shift(solid.name));
    const [x, y, z] = mesh.nodes, [i, j, k] = mesh.corners;
    const [colouring, high] = this.chosen(solid);
    const note = solid.notes.length ? `: ${solid.notes[time]}` : "";
    const labelled = solid.labels.length || solid.nodes !== null;
    const colours = colouring === undefined ? { color: solid.colour } : {
      ...coloured(solid, time, colouring, high, mesh), showscale: hasBar,
      colorbar: colourBar(this.place, colouring),
    };
    return {
      type: "mesh3d", name: solid.name + note, legendgroup: solid.name.split(",")[0],
      showlegend: !solid.name.includes(",") && (colouring?.nodal ?? true), x, y, z, i, j, k, opacity: solid.opacity, flatshading: true,
      lightposition: LIGHT, lighting: colouring && !colouring.nodal ? { ...BOX_SHADE, ambient: 0.95, diffuse: 0.1 } : BOX_SHADE,
      hoverinfo: labelled ? "text" : "skip", text: labelled ? hovered(solid, time, colouring, mesh) : undefined, ...colours,
    };
  }

  traces() {
    const apart = Number(this.control.gap?.value ?? 0) !== 0;
    const isThere = ({ name }) => (this.isShown("ground") || name !== "ground")
      && ((this.isShown("rollers") && !apart) || !name.includes("rollers"));
    let hasBar = false;
    const solids = this.scene.solids.filter(isThere).map((solid) => {
      const drawn = this.solid(solid, !hasBar && solid.colourings.length > 0);
      hasBar ||= solid.colourings.length > 0;
      return drawn;
    });
    const pushing = this.isShown("forces") ? this.scene.arrows : [];
    return [...solids, ...pushing.flatMap((one) => arrows(one, this.now(), this.shift(one.solid)))];
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

  draw() {
    if (this.control["time-shown"]) this.control["time-shown"].textContent = this.scene.titles[this.now()];
    const traces = this.traces();
    const ranges = this.scene.window ?? this.ranges(traces);
    const lies = traces.some((trace) => trace.showscale && trace.colorbar.orientation === "h");
    const layout = viewLayout(this.place, ranges, CAMERAS[this.camera], this.looks, lies);
    // Plotly leaves the title of a bar that is laid down or set up where it was
    if (this.lies !== undefined && this.lies !== lies) Plotly.purge(this.place);
    this.lies = lies;
    return Plotly.react(this.place, traces, layout, CONFIG);
  }

  /* play from the time shown, or from the start again at the end */
  async play(on) {
    const { play, time } = this.control;
    this.playing = on;
    play.textContent = on ? "stop" : "play";
    if (on && time.value === time.max) time.value = -1;
    while (this.playing && Number(time.value) < Number(time.max)) {
      time.value = Number(time.value) + 1;
      await this.draw();
      await new Promise((wake) => { setTimeout(wake, 60); });
    }
    if (this.playing) this.play(false);
  }
}

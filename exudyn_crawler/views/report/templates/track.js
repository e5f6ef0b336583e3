/* whole track, moving */

class TrackView {
  constructor(place, tracks) {
    this.place = place;
    this.tracks = tracks;
    const control = (id) => document.getElementById(id);
    this.case = control("track-case");
    this.time = control("track-time");
    this.shown = control("track-time-shown");
    this.forces = control("track-forces");
    this.ground = control("track-ground");
    this.button = control("track-play");
    this.camera = "aslant";
    this.looks = 0;
    const names = Object.keys(tracks);
    this.case.replaceChildren(...names.map((name) => element("option", { value: name }, name)));
    this.case.hidden = names.length < 2;
    this.case.onchange = () => this.pick(this.case.value);
    for (const input of [this.time, this.forces, this.ground]) input.oninput = () => this.draw();
    this.button.onclick = () => this.play(!this.playing);
    for (const button of document.querySelectorAll("[data-camera]")) {
      button.onclick = () => this.look(button.dataset.camera);
    }
    this.pick(names[0]);
  }

  pick(name) {
    const track = this.tracks[name];
    this.track = track;
    this.read = { corners: unpack(track.ground.corners, "f4"), heave: unpack(track.ground.heave, "i2"), box: boxCorners(track.box) };
    for (const key of ["origin", "turn", "points", "forces"]) {
      this.read[key] = unpack(track[key], "f4");
      if (track.undercarriage) this.read[`frame ${key}`] = unpack(track.undercarriage[key], "f4");
    }
    this.time.max = track.times.length - 1;
    this.time.value = 0;
    this.draw();
  }

  /* from a named side, wherever the reader has turned the view */
  look(name) {
    this.camera = name;
    this.looks += 1;
    this.draw();
  }

  /* part of an array that belongs to the time shown */
  now(key) {
    const values = this.read[key];
    const size = values.length / this.track.times.length;
    return values.subarray(size * Number(this.time.value), size * (Number(this.time.value) + 1));
  }

  bodies(flexible, name, colour) {
    const { shoes } = this.track;
    const origin = this.now("origin"), turn = this.now("turn");
    const chosen = shoes.map((_, index) => index).filter((index) => this.track.flexible.includes(shoes[index]) === flexible);
    const parts = chosen.map((index) =>
      placed(this.read.box, origin.subarray(3 * index, 3 * index + 3), turn.subarray(9 * index, 9 * index + 9)));
    const body = surface(parts, BOX, name, colour);
    const text = chosen.flatMap((index) => Array(8).fill(`shoe ${shoes[index]}`));
    return { ...body, text, hoverinfo: "text", showlegend: true };
  }

  terrain() {
    const { step, limits } = this.track.ground;
    const heave = this.now("heave"), corners = this.read.corners;
    const units = heave.length;
    const at = (axis) => Float32Array.from({ length: 4 * units }, (_, corner) =>
      corners[3 * corner + axis] + (axis === 2 ? step * heave[corner >> 2] : 0));
    const node = (corner) => Uint32Array.from({ length: 2 * units }, (_, half) =>
      4 * (half >> 1) + (half % 2 ? [0, 2, 3] : [0, 1, 2])[corner]);
    return {
      type: "mesh3d", name: "ground", x: at(0), y: at(1), z: at(2), i: node(0), j: node(1), k: node(2),
      intensity: Float32Array.from({ length: 2 * units }, (_, half) => 1e3 * step * heave[half >> 1]),
      intensitymode: "cell", cmin: limits[0], cmax: limits[1], colorscale: "Cividis", flatshading: true,
      hoverinfo: "skip", opacity: 0.6, lighting: { ambient: 0.95, diffuse: 0.1, specular: 0, fresnel: 0, facenormalsepsilon: 0 },
      colorbar: lyingBar(this.place, "heave of the ground in mm"),
    };
  }

  sideFrame() {
    const { undercarriage: shape, colours, force_scale: scale } = this.track;
    const frame = { origin: this.now("frame origin"), turn: this.now("frame turn") };
    const beam = surface([placed(boxCorners(shape.beam), frame.origin, frame.turn)], BOX, "side frame", colours.frame, 0.6);
    const traces = [beam, rollerSurface(shape, frame, colours.roller)].map((trace) => ({ ...trace, showlegend: true }));
    if (!this.forces.checked) return traces;
    return [...traces, ...arrows(this.now("frame points"), this.now("frame forces"), scale, colours.pressing, "forces of rollers")];
  }

  draw() {
    const { colours, window: range, times, force_scale: scale, flexible, undercarriage } = this.track;
    this.shown.textContent = `t = ${times[Number(this.time.value)].toFixed(2)} s`;
    const traces = [this.bodies(false, "rigid shoes", colours.shoe)];
    if (flexible.length) traces.push(this.bodies(true, "flexible shoes", colours.flexible));
    if (this.ground.checked) traces.push(this.terrain());
    if (undercarriage) traces.push(...this.sideFrame());
    if (this.forces.checked) traces.push(...arrows(this.now("points"), this.now("forces"), scale, data.arrows, "contact forces"));
    const spans = range.map(([low, high]) => high - low);
    // the cameras count on a length of 2
    const aspect = spans.map((span) => 2 * span / spans[0]);
    const layout = viewLayout(this.place, range, aspect, CAMERAS[this.camera], this.looks, this.ground.checked);
    return Plotly.react(this.place, traces, layout, CONFIG);
  }

  /* play from the time shown, or from the start again at the end */
  async play(on) {
    this.playing = on;
    this.button.textContent = on ? "stop" : "play";
    if (on && this.time.value === this.time.max) this.time.value = -1;
    while (this.playing && Number(this.time.value) < Number(this.time.max)) {
      this.time.value = Number(this.time.value) + 1;
      await this.draw();
      await new Promise((wake) => { setTimeout(wake, 60); });
    }
    if (this.playing) this.play(false);
  }
}

const CAMERAS = {
  aslant: { eye: { x: -0.7, y: -1.45, z: 0.85 }, up: { x: 0, y: 0, z: 1 }, center: { x: 0, y: 0, z: 0 } },
  above: { eye: { x: 0, y: 0, z: 1.5 }, up: { x: 0, y: 1, z: 0 }, center: { x: 0, y: 0, z: 0 } },
  side: { eye: { x: 0, y: -1.5, z: 0 }, up: { x: 0, y: 0, z: 1 }, center: { x: 0, y: 0, z: 0 } },
};

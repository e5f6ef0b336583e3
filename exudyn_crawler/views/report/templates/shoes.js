/* flexible shoes */

/* m beyond the middles of the outer shoes that rollers are drawn */
const ROLLERS_BESIDE = 0.75;

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
    // beside a narrow view a bar would hide shoes
    const bar = (title) => (NARROW.matches ? lyingBar(this.place, title.replace("<br>", " "))
      : { title: { text: title }, x: 0, xanchor: "left", len: 0.8 });
    if (!this.trust.checked) {
      return {
        intensity: stress, cmin: 0, cmax: Number(this.limit.value) || this.shoes.limit,
        colorbar: bar("von Mises<br>in MPa"),
        text: Array.from(stress, (value) => `${name}: ${value.toFixed(1)} MPa`),
      };
    }
    const words = this.shoes.verdicts;
    const numbers = Array.from(unpack(this.shoes.verdict[index], "i2"));
    return {
      intensity: numbers.map((number) => (number < 0 ? NaN : number)), cmin: 0, cmax: words.length - 1,
      colorbar: { ...bar("greatest stress"), ...this.verdictTicks(words) },
      text: numbers.map((number) => `${name}: ${words[number] ?? "not known, the drive pulls here"}`),
    };
  }

  /* all words beside the bar; below a lying one the first, the middle and the last, in short */
  verdictTicks(words) {
    const last = words.length - 1;
    const shown = NARROW.matches ? [0, Math.round(last / 2), last] : words.map((_, k) => k);
    const short = (word) => word.split(":")[0];
    const ticktext = shown.map((k) => (NARROW.matches ? short(words[k]) : words[k]));
    return { tickvals: shown, ticktext, ...(NARROW.matches ? { len: 0.7 } : {}) };
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
    const layout = viewLayout(this.place, ranges, aspect, SHOE_CAMERA, "shoes", NARROW.matches);
    // Plotly leaves the title of a bar that is laid down or set up where it was
    if (this.lies !== undefined && this.lies !== NARROW.matches) Plotly.purge(this.place);
    this.lies = NARROW.matches;
    Plotly.react(this.place, traces, layout, CONFIG);
  }
}

/* 3D views on screens of any width */

const NARROW = window.matchMedia("(max-width: 640px)");
/* where nothing hovers, Plotly always shows its toolbar */
const TOUCHED = window.matchMedia("(hover: none)");

/* pixels: height of the toolbar, of a lying colour bar with its title, and room for what stands beside the axes */
const TOOLBAR = 34, COLOUR_BAR = 64;
const BESIDE = { x: 34, y: 44 };

/* half of the upright angle that Plotly's cameras see */
const HALF_ANGLE = Math.PI / 8;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((value) => value / Math.hypot(...a));
const listed = ({ x, y, z }) => [x, y, z];

/* camera as near as it sees all of the box about the axes from its side, in a view of so many pixels;
   aspect: edges of the box along x, y and z as the camera counts them */
function fitted(camera, aspect, width, height) {
  const back = unit(listed(camera.eye));
  const right = unit(cross(listed(camera.up), back));
  const upward = cross(back, right);
  const seen = Math.tan(HALF_ANGLE) / height;
  const half = [seen * Math.max(width - 2 * BESIDE.x, 1), seen * Math.max(height - 2 * BESIDE.y, 1)];
  const corners = Array.from({ length: 8 }, (_, corner) => aspect.map((edge, k) => ((corner >> k) & 1 ? 0.5 : -0.5) * edge))
    .map((place) => ({ depth: dot(place, back), at: [dot(place, right), dot(place, upward)] }));
  const middle = [0, 0];
  let distance;
  // near edges are seen larger: what is in the middle of the view is not the middle of the box
  for (let turn = 0; turn < 8; turn++) {
    distance = Math.max(...corners.flatMap(({ depth, at }) => half.map((most, k) => depth + Math.abs(at[k] - middle[k]) / most)));
    for (const k of [0, 1]) {
      const slopes = corners.map(({ depth, at }) => (at[k] - middle[k]) / (distance - depth));
      middle[k] += 0.5 * distance * (Math.min(...slopes) + Math.max(...slopes));
    }
  }
  const centre = right.map((value, k) => middle[0] * value + middle[1] * upward[k]);
  const point = ([x, y, z]) => ({ x, y, z });
  return { up: camera.up, center: point(centre), eye: point(centre.map((value, k) => value + distance * back[k])) };
}

/* layout of a view: ranges of the axes (m), a camera, and what it is renewed for; the toolbar and a lying colour bar
   have strips of their own */
function viewLayout(place, ranges, camera, renewed, hasLyingBar) {
  const spans = ranges.map(([low, high]) => high - low);
  // cameras count on a box of a volume of one
  const aspect = spans.map((span) => span / Math.cbrt(spans[0] * spans[1] * spans[2]));
  const margin = { l: 0, r: 0, t: TOUCHED.matches ? TOOLBAR : 0, b: hasLyingBar ? COLOUR_BAR : 0, autoexpand: false };
  const height = place.clientHeight - margin.t - margin.b;
  const axis = (name, at) => ({ title: { text: `${name} in m` }, range: ranges[at], nticks: NARROW.matches ? 5 : 0 });
  return {
    uirevision: "kept", margin, legend: { x: 1, xanchor: "right" },
    scene: {
      // a reader's own camera stays until the width of the screen changes
      uirevision: `${renewed} ${place.clientWidth}`,
      aspectmode: "manual", aspectratio: { x: aspect[0], y: aspect[1], z: aspect[2] },
      xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: { ...axis("z", 2), nticks: NARROW.matches ? 3 : 4 },
      camera: fitted(camera, aspect, place.clientWidth, height),
    },
  };
}

/* colour bar of a view: below it, or at its left where many words stand beside it */
function colourBar(place, { title, words, decades, low, high }) {
  const all = words.map((_, k) => k);
  const lies = NARROW.matches || !words.length;
  const shown = NARROW.matches ? [0, Math.round(0.5 * (all.length - 1)), all.length - 1] : all;
  const ticks = words.length ? { tickvals: shown, ticktext: shown.map((k) => (NARROW.matches ? words[k].split(":")[0] : words[k])) } : {};
  if (decades) {
    const powers = Array.from({ length: Math.floor(high) - Math.ceil(low) + 1 }, (_, k) => Math.ceil(low) + k);
    Object.assign(ticks, { tickvals: powers, ticktext: powers.map((power) => `1e${power}`) });
  }
  if (!lies) return { title: { text: title }, x: 0, xanchor: "left", len: 0.8, ...ticks };
  const view = place.clientHeight - COLOUR_BAR - (TOUCHED.matches ? TOOLBAR : 0);
  return {
    title: { text: title, side: "top" }, orientation: "h", y: -COLOUR_BAR / view, yanchor: "bottom",
    len: words.length ? 0.7 : NARROW.matches ? 0.9 : 0.4, thickness: 14, ypad: 4,
    ...(Object.keys(ticks).length ? ticks : { nticks: NARROW.matches ? 5 : 8 }),
  };
}

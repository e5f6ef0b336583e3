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

/* camera that steps back, if it must, until it sees all of the box about the axes, in a view of so many pixels;
   aspect: edges of the box along x, y and z as the camera counts them */
function steppedBack(camera, aspect, width, height) {
  const centre = listed(camera.center);
  const away = listed(camera.eye).map((value, k) => value - centre[k]);
  const back = unit(away);
  const right = unit(cross(listed(camera.up), back));
  const upward = cross(back, right);
  const seen = Math.tan(HALF_ANGLE) / height;
  const across = seen * Math.max(width - 2 * BESIDE.x, 1), along = seen * Math.max(height - 2 * BESIDE.y, 1);
  let distance = Math.hypot(...away);
  for (let corner = 0; corner < 8; corner++) {
    const place = aspect.map((edge, k) => ((corner >> k) & 1 ? 0.5 : -0.5) * edge - centre[k]);
    const beside = Math.max(Math.abs(dot(place, right)) / across, Math.abs(dot(place, upward)) / along);
    distance = Math.max(distance, dot(place, back) + beside);
  }
  const [x, y, z] = back.map((value, k) => centre[k] + distance * value);
  return { ...camera, eye: { x, y, z } };
}

/* layout of a view: ranges of the axes (m), a camera that counts on their box, and what it is renewed for; the
   toolbar and a lying colour bar have strips of their own */
function viewLayout(place, ranges, aspect, camera, renewed, lyingBar) {
  const margin = { l: 0, r: 0, t: TOUCHED.matches ? TOOLBAR : 0, b: lyingBar ? COLOUR_BAR : 0, autoexpand: false };
  const height = place.clientHeight - margin.t - margin.b;
  const axis = (name, at) => ({ title: { text: `${name} in m` }, range: ranges[at], nticks: NARROW.matches ? 5 : 0 });
  return {
    uirevision: "kept", margin, legend: { x: 1, xanchor: "right" },
    scene: {
      // a reader's own camera stays until the width of the screen changes
      uirevision: `${renewed} ${place.clientWidth}`,
      aspectmode: "manual", aspectratio: { x: aspect[0], y: aspect[1], z: aspect[2] },
      xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: { ...axis("z", 2), nticks: NARROW.matches ? 3 : 4 },
      camera: steppedBack(camera, aspect, place.clientWidth, height),
    },
  };
}

/* colour bar below a view */
function lyingBar(place, title) {
  const view = place.clientHeight - COLOUR_BAR - (TOUCHED.matches ? TOOLBAR : 0);
  return {
    title: { text: title, side: "top" }, orientation: "h", y: -COLOUR_BAR / view, yanchor: "bottom",
    len: NARROW.matches ? 0.9 : 0.4, thickness: 14, ypad: 4, nticks: NARROW.matches ? 5 : 8,
  };
}

/* bodies of 3D views; each function gives what Plotly draws */

/* points (flat, m) of a body at an origin with a rotation matrix (row by row), as [x, y, z] */
function placed(points, origin, turn) {
  const count = points.length / 3;
  const place = [new Float32Array(count), new Float32Array(count), new Float32Array(count)];
  for (let point = 0; point < count; point++) {
    for (let axis = 0; axis < 3; axis++) {
      place[axis][point] = origin[axis] + turn[3 * axis] * points[3 * point]
        + turn[3 * axis + 1] * points[3 * point + 1] + turn[3 * axis + 2] * points[3 * point + 2];
    }
  }
  return place;
}

/* one surface of several: parts are [x, y, z] each, with the same triangles (flat) */
function surface(parts, triangle, name, colour, opacity = 1) {
  const size = parts.length ? parts[0][0].length : 0;
  const [x, y, z] = [0, 1, 2].map((axis) => Float32Array.from(parts.flatMap((part) => [...part[axis]])));
  const [i, j, k] = [0, 1, 2].map((corner) => Uint32Array.from(parts.flatMap((_, number) =>
    [...triangle].filter((_, index) => index % 3 === corner).map((node) => node + number * size))));
  return {
    type: "mesh3d", name, x, y, z, i, j, k, color: colour, opacity, flatshading: true, hoverinfo: "skip",
    lighting: { ambient: 0.7, diffuse: 0.5, specular: 0, fresnel: 0, facenormalsepsilon: 0 },
    lightposition: { x: -30000, y: -60000, z: 90000 },
  };
}

const BOX = [0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7];

/* corners (flat) of a box between two places */
function boxCorners([low, high]) {
  return [low, high].flatMap(({ 2: z }) =>
    [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]].flatMap(([x, y]) => [x, y, z]));
}

/* forces (flat, N) that act at points (flat, m): lines with heads there; those at no place are left out */
function arrows(points, forces, scale, colour, name) {
  const lines = { x: [], y: [], z: [] };
  const heads = { x: [], y: [], z: [], u: [], v: [], w: [] };
  for (let at = 0; at < points.length; at += 3) {
    const length = Math.hypot(forces[at], forces[at + 1], forces[at + 2]);
    if (!(length > 0) || Number.isNaN(points[at])) continue;
    ["x", "y", "z"].forEach((axis, k) => {
      lines[axis].push(points[at + k] - scale * forces[at + k], points[at + k], null);
      heads[axis].push(points[at + k]);
      heads["uvw"[k]].push(forces[at + k] / length);
    });
  }
  return [
    { ...lines, type: "scatter3d", mode: "lines", line: { color: colour, width: 4 }, name, hoverinfo: "skip", showlegend: false },
    { ...heads, type: "cone", anchor: "tip", sizemode: "absolute", sizeref: 0.08, showscale: false,
      colorscale: [[0, colour], [1, colour]], name, hoverinfo: "skip", showlegend: false },
  ];
}

/* treads of the rollers that are chosen by their place along x; frame has origin and turn */
function rollerSurface(shape, frame, colour, chosen = () => true) {
  const tread = unpack(shape.tread, "f4");
  const parts = [];
  for (const roller of shape.rollers) {
    if (!chosen(placed([roller, 0, 0], frame.origin, frame.turn)[0][0])) continue;
    for (const middle of shape.middles) {
      const own = tread.map((value, index) => value + [roller, middle, 0][index % 3]);
      parts.push(placed(own, frame.origin, frame.turn));
    }
  }
  return surface(parts, unpack(shape.triangle, "u4"), "rollers", colour);
}

/* phases of a case behind its curves over time */

const NAME_SIZE = 10.5;

/* a light band a phase, over all panels */
function phaseBands(phases) {
  return phases.map(({ begin, end }, number) => ({
    type: "rect", layer: "below", xref: "x", yref: "paper", x0: begin, x1: end, y0: 0, y1: 1,
    line: { width: 0 }, fillcolor: data.bands[number % data.bands.length],
  }));
}

/* names above what is seen of the bands, as far as they have room there; axis is Plotly's own of the time */
function phaseNames(phases, axis) {
  const pen = document.createElement("canvas").getContext("2d");
  pen.font = `${NAME_SIZE}px "Open Sans", verdana, arial, sans-serif`;
  const [low, high] = axis.range;
  const named = [];
  for (const { name, begin, end } of phases) {
    const from = Math.max(begin, low), to = Math.min(end, high);
    if (from >= to || pen.measureText(name).width + 6 > axis.d2p(to) - axis.d2p(from)) continue;
    named.push({
      xref: "x", yref: "paper", x: from, y: 1, xanchor: "left", yanchor: "bottom", xshift: 1, showarrow: false,
      borderpad: 1, font: { size: NAME_SIZE, color: data.phase_name },
      // Plotly would take a name with < for a format
      text: name.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;"),
    });
  }
  return named;
}

// Linkages that move beside the wanted path or positions: one canvas for each design, all in step.
const SIZE = 420, MARGIN = 24, SECONDS = 4;

/** The map from metres, or degrees, to the canvas, on which all these points are visible. */
function frame(points, equal) {
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const point of points) for (const axis of [0, 1]) {
    low[axis] = Math.min(low[axis], point[axis]);
    high[axis] = Math.max(high[axis], point[axis]);
  }
  const room = SIZE - 2 * MARGIN;
  let scale = [0, 1].map((axis) => room / Math.max(high[axis] - low[axis], 1e-9));
  if (equal) scale = [Math.min(...scale), Math.min(...scale)];
  return (point) => [MARGIN + (point[0] - low[0]) * scale[0], SIZE - MARGIN - (point[1] - low[1]) * scale[1]];
}

function polyline(context, points, to, colour, width) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.beginPath();
  points.map(to).forEach(([x, y], index) => index ? context.lineTo(x, y) : context.moveTo(x, y));
  context.stroke();
}

function dots(context, points, to, colour, radius) {
  context.fillStyle = colour;
  for (const [x, y] of points.map(to)) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
  }
}

/** Adds the design's figure; the function that draws it at a share of its motion. */
function figure(design) {
  const place = document.createElement("figure"), caption = document.createElement("figcaption");
  const canvas = document.createElement("canvas"), context = canvas.getContext("2d");
  canvas.width = canvas.height = SIZE;
  caption.textContent = design.label;
  place.append(canvas, caption);
  document.getElementById("designs").append(place);
  const moved = design.lines.flat(2), marks = data.marks.flat();
  const to = frame([...moved, ...design.carried.flat(), ...data.points, ...marks], true);
  const graph = design.reached.length ? frame([...design.reached, ...data.function], false) : null;
  return (share) => {
    const at = Math.round(share * (design.lines[0].length - 1));
    context.clearRect(0, 0, SIZE, SIZE);
    if (graph) {
      polyline(context, design.reached, graph, "#ccd", 1.5);
      dots(context, data.function, graph, "#d62", 2.5);
    }
    if (design.trace.length) polyline(context, design.trace, to, "#7ab", 1.5);
    for (const line of design.lines) polyline(context, line[at], to, "#345", 3);
    for (const line of design.lines) dots(context, line[at], to, "#345", 4);
    for (const mark of data.marks) polyline(context, mark, to, "#d62", 2);
    if (design.carried.length) polyline(context, design.carried[at], to, "#07c", 3);
    dots(context, data.points, to, "#d62", 3.5);
    if (design.trace.length) dots(context, [design.trace[at]], to, "#07c", 5);
  };
}

const draws = data.designs.map(figure);
function step(time) {
  const share = (time / 1000 / SECONDS) % 2;
  for (const draw of draws) draw(data.turns ? share % 1 : share < 1 ? share : 2 - share);
  requestAnimationFrame(step);
}
requestAnimationFrame(step);

// Draws the map: what does not change goes into a layer of its own, a little larger than the picture, which is only
// drawn anew when the view leaves it or zooms; each frame puts the layer there and draws what moves.

import { View } from "./view.js";

// So much of the picture's size is added to the layer at each side: panning and following need no redrawing meanwhile.
const RIM = 0.3;
// Points nearer than this to the last one drawn are not seen, pixels.
const FINE = 0.7;
const CHUNK = 4000;
const GRID_PX = 56;
const ROBOT_MM = 70;
const ROBOT_PX = 13;
const LIMIT_MS = 5000;
// A robot so near to the chosen one has no name written over that one's.
const NEAR_PX = 34;

export const PEN_COLOURS = {
  light: ["#0b6e6e", "#b3421b", "#4a3fb5", "#8a1c5b", "#1f6b2d", "#7a5900"],
  dark: ["#4fd0c5", "#ff9a6b", "#a9a2ff", "#f58bc4", "#7fd98f", "#e2bf4f"],
};

export class Painter {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.layer = document.createElement("canvas");
    this.layerContext = this.layer.getContext("2d");
    this.view = new View();
    this.drawn = null; // the view that the layer shows: {x, y, scale, width, height, ...}
    this.colours = {};
    this.ratio = 1;
    this.redraws = 0;
    this.settledOf = new Map();
  }

  resize(width, height, ratio) {
    this.ratio = ratio;
    this.view.width = Math.max(1, width);
    this.view.height = Math.max(1, height);
    this.canvas.width = Math.max(1, Math.round(width * ratio));
    this.canvas.height = Math.max(1, Math.round(height * ratio));
    this.forget();
  }

  setColours(colours) {
    this.colours = colours;
    this.forget();
  }

  forget() {
    this.drawn = null;
  }

  // The distance between two lines of the grid, mm.
  get step() {
    return this.view.spacing(GRID_PX);
  }

  penColour(order, pen) {
    const palette = PEN_COLOURS[this.colours.isDark ? "dark" : "light"];
    return palette[(order + Math.max(0, pen - 1)) % palette.length];
  }

  // ---------------------------------------------------------------- the layer

  // robots: [{name, label, order, isChosen, link, pose, path, obstacles, overlay, limits}]; now: milliseconds.
  paint(robots, now) {
    const { context, view, ratio } = this;
    this.bringLayerUpToDate(robots);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.colours.ground;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    const [left, top] = [
      ((this.drawn.x - view.x) * view.scale - this.drawn.width / 2 + view.width / 2) * ratio,
      ((view.y - this.drawn.y) * view.scale - this.drawn.height / 2 + view.height / 2) * ratio,
    ];
    context.drawImage(this.layer, Math.round(left), Math.round(top));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (const robot of robots) this.drawTip(robot);
    for (const robot of robots) if (robot.overlay) this.drawOverlay(robot);
    for (const robot of robots) this.drawLimits(robot, now);
    const chosen = robots.find((robot) => robot.isChosen);
    for (const robot of robots) if (robot !== chosen) this.drawRobot(robot, chosen);
    if (chosen) this.drawRobot(chosen, null);
  }

  bringLayerUpToDate(robots) {
    const { view, drawn } = this;
    const fits =
      drawn &&
      drawn.scale === view.scale &&
      drawn.key === this.layerKey(robots) &&
      Math.abs(view.x - drawn.x) * view.scale <= (drawn.width - view.width) / 2 &&
      Math.abs(view.y - drawn.y) * view.scale <= (drawn.height - view.height) / 2 &&
      robots.every((robot) => robot.path.settled >= (this.settledOf.get(robot.name) ?? 0));
    if (fits) {
      for (const robot of robots) this.settle(robot);
      return;
    }
    this.redraws += 1;
    const { ratio } = this;
    const [width, height] = [Math.round(view.width * (1 + 2 * RIM)), Math.round(view.height * (1 + 2 * RIM))];
    this.drawn = { x: view.x, y: view.y, scale: view.scale, width, height, key: this.layerKey(robots) };
    if (this.layer.width !== Math.round(width * ratio) || this.layer.height !== Math.round(height * ratio)) {
      this.layer.width = Math.round(width * ratio);
      this.layer.height = Math.round(height * ratio);
    }
    this.layerContext.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.layerContext.fillStyle = this.colours.ground;
    this.layerContext.fillRect(0, 0, width, height);
    this.drawGrid();
    for (const robot of robots) this.drawObstacles(robot);
    this.settledOf.clear();
    for (const robot of robots) {
      robot.path.settled = 0;
      this.settle(robot);
    }
  }

  // What is in the layer besides the paths.
  layerKey(robots) {
    return robots.map((robot) => `${robot.name} ${robot.path.generation} ${robot.obstacles.length}`).join("|");
  }

  onLayer(x, y) {
    const { drawn } = this;
    return [(x - drawn.x) * drawn.scale + drawn.width / 2, (drawn.y - y) * drawn.scale + drawn.height / 2];
  }

  // The last point may still move: all before it are settled, and go into the layer once.
  settle(robot) {
    const { path } = robot;
    const end = Math.max(0, path.length - 1);
    if (path.settled < end) {
      this.drawPath(robot, Math.max(1, path.settled), end);
      path.settled = end;
    }
    this.settledOf.set(robot.name, path.settled);
  }

  // The lines that end at the points from `start` up to `end` (not included).
  drawPath({ path, order }, start, end) {
    const { layerContext: context, drawn } = this;
    const { scale } = drawn;
    const [dx, dy] = [drawn.width / 2 - drawn.x * scale, drawn.height / 2 + drawn.y * scale];
    let i = start;
    while (i < end) {
      const pen = path.pen[i];
      const last = Math.min(end, i + CHUNK);
      context.beginPath();
      let [px, py] = [path.x[i - 1] * scale + dx, dy - path.y[i - 1] * scale];
      context.moveTo(px, py);
      let isPending = false;
      let [x, y] = [px, py];
      for (; i < last && path.pen[i] === pen; i += 1) {
        x = path.x[i] * scale + dx;
        y = dy - path.y[i] * scale;
        isPending = Math.abs(x - px) + Math.abs(y - py) < FINE;
        if (!isPending) {
          context.lineTo(x, y);
          [px, py] = [x, y];
        }
      }
      if (isPending) context.lineTo(x, y);
      this.stroke(context, order, pen);
    }
  }

  stroke(context, order, pen) {
    context.lineJoin = context.lineCap = "round";
    context.lineWidth = pen ? 2 : 1;
    context.strokeStyle = pen ? this.penColour(order, pen) : this.colours.penUp;
    context.stroke();
  }

  drawGrid() {
    const { layerContext: context, drawn, colours } = this;
    const step = this.step;
    const [left, top] = [drawn.x - drawn.width / 2 / drawn.scale, drawn.y + drawn.height / 2 / drawn.scale];
    const [right, bottom] = [drawn.x + drawn.width / 2 / drawn.scale, drawn.y - drawn.height / 2 / drawn.scale];
    const lines = (first, last, draw) => {
      for (let n = Math.ceil(first / step); n * step <= last; n += 1) draw(n);
    };
    context.lineWidth = 1;
    for (const isAxis of [false, true]) {
      context.beginPath();
      lines(left, right, (n) => {
        if ((n === 0) !== isAxis) return;
        const x = Math.round(this.onLayer(n * step, 0)[0]) + 0.5;
        context.moveTo(x, 0);
        context.lineTo(x, drawn.height);
      });
      lines(bottom, top, (n) => {
        if ((n === 0) !== isAxis) return;
        const y = Math.round(this.onLayer(0, n * step)[1]) + 0.5;
        context.moveTo(0, y);
        context.lineTo(drawn.width, y);
      });
      context.strokeStyle = isAxis ? colours.axis : colours.grid;
      context.stroke();
    }
  }

  drawObstacles({ obstacles }) {
    const { layerContext: context, colours, drawn } = this;
    context.strokeStyle = colours.wall;
    context.fillStyle = colours.wallFill;
    context.lineWidth = 3;
    context.lineCap = "round";
    for (const obstacle of obstacles) {
      context.beginPath();
      if (obstacle.length === 3) {
        const [x, y] = this.onLayer(obstacle[0], obstacle[1]);
        context.arc(x, y, obstacle[2] * drawn.scale, 0, 2 * Math.PI);
        context.fill();
      } else {
        context.moveTo(...this.onLayer(obstacle[0], obstacle[1]));
        context.lineTo(...this.onLayer(obstacle[2], obstacle[3]));
      }
      context.stroke();
    }
  }

  // ---------------------------------------------------------------- what moves

  drawTip({ path, order }) {
    const { context, view } = this;
    const last = path.length - 1;
    if (last < 0) return;
    context.beginPath();
    context.moveTo(...view.toScreen(path.x[Math.max(0, last - 1)], path.y[Math.max(0, last - 1)]));
    context.lineTo(...view.toScreen(path.x[last], path.y[last]));
    this.stroke(context, order, path.pen[last]);
  }

  drawOverlay({ overlay }) {
    const { context, view, colours } = this;
    context.save();
    context.lineCap = "butt";
    for (const { pen, points } of overlay) {
      context.beginPath();
      points.forEach(([x, y], i) => context[i ? "lineTo" : "moveTo"](...view.toScreen(x, y)));
      context.setLineDash(pen ? [7, 5] : [1, 5]);
      context.lineWidth = pen ? 2 : 1.5;
      context.strokeStyle = colours.preview;
      context.stroke();
    }
    context.restore();
  }

  drawLimits({ limits }, now) {
    const { context, view, colours } = this;
    for (const { x, y, since } of limits) {
      const age = now - since;
      if (age > LIMIT_MS) continue;
      const [px, py] = view.toScreen(x, y);
      context.globalAlpha = Math.min(1, (LIMIT_MS - age) / 1000);
      context.strokeStyle = context.fillStyle = colours.danger;
      context.lineWidth = 3;
      context.beginPath();
      context.arc(px, py, 26, 0, 2 * Math.PI);
      context.stroke();
      context.beginPath();
      context.roundRect(px - 2, py - 46, 4, 12, 2);
      context.fill();
      context.beginPath();
      context.arc(px, py - 30.5, 2.2, 0, 2 * Math.PI);
      context.fill();
      context.globalAlpha = 1;
    }
  }

  isShowingLimit(robots, now) {
    return robots.some((robot) => robot.limits.some(({ since }) => now - since <= LIMIT_MS));
  }

  drawRobot({ pose, order, isChosen, label, link }, chosen) {
    if (!pose) return;
    const isCovered = chosen?.pose && Math.hypot(chosen.pose.x - pose.x, chosen.pose.y - pose.y) * this.view.scale < NEAR_PX;
    const { context, view, colours } = this;
    const [x, y] = view.toScreen(pose.x, pose.y);
    const size = Math.max(ROBOT_PX, ROBOT_MM * view.scale);
    context.save();
    context.translate(x, y);
    context.globalAlpha = isChosen ? 1 : 0.6;
    context.save();
    context.rotate((pose.heading * Math.PI) / 180);
    context.beginPath();
    context.moveTo(0, -size);
    context.quadraticCurveTo(size * 0.35, -size * 0.1, size * 0.72, size * 0.78);
    context.quadraticCurveTo(0, size * 0.3, -size * 0.72, size * 0.78);
    context.quadraticCurveTo(-size * 0.35, -size * 0.1, 0, -size);
    context.closePath();
    context.lineJoin = "round";
    context.fillStyle = link === "connected" ? this.penColour(order, 1) : colours.off;
    context.strokeStyle = colours.ground;
    context.lineWidth = 2.5;
    context.stroke();
    context.fill();
    context.restore();
    if (label && !isCovered) {
      context.font = `${isChosen ? 600 : 400} 13px Roboto, system-ui, sans-serif`;
      context.textAlign = "center";
      context.textBaseline = "top";
      context.lineWidth = 4;
      context.strokeStyle = colours.ground;
      context.fillStyle = colours.ink;
      context.strokeText(label, 0, size + 5);
      context.fillText(label, 0, size + 5);
    }
    context.restore();
  }
}

// A distance for people: 5 mm, 20 cm, 1 m, 2 km.
export function length(mm) {
  const [value, unit] = mm >= 1e6 ? [mm / 1e6, "km"] : mm >= 1000 ? [mm / 1000, "m"] : mm >= 100 ? [mm / 10, "cm"] : [mm, "mm"];
  return `${Number(value.toPrecision(6))} ${unit}`;
}

// Draws the map: a layer of what does not move, put where the view is, and over it in each frame what moves.

import { Layer } from "./layer.js";
import { View } from "./view.js";

// Points of paths that are drawn in a frame, and what a slow frame is.
const [LEAST, FIRST, MOST] = [1500, 6000, 60000];
const SLOW_MS = 24;
// Lines that are drawn in each frame while the layer is behind.
const TIP = 50;
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
    this.view = new View();
    this.front = new Layer(); // what is shown
    this.spare = new Layer();
    this.next = null; // what is being drawn, to be shown next
    this.budget = FIRST;
    this.before = 0;
    this.isBehind = false;
    this.colours = {};
    this.ratio = 1;
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
    this.front.key = this.next = null;
  }

  // The distance between two lines of the grid, mm.
  get step() {
    return this.view.spacing(GRID_PX);
  }

  penColour(order, pen) {
    const palette = PEN_COLOURS[this.colours.isDark ? "dark" : "light"];
    return palette[(order + Math.max(0, pen - 1)) % palette.length];
  }

  // ---------------------------------------------------------------- the layers

  // robots: [{name, label, order, isChosen, link, pose, path, obstacles, overlay, limits}]; now: milliseconds.
  // Whether there is more to draw of what does not move.
  paint(robots, now) {
    const { context, view, ratio } = this;
    this.bringUpToDate(robots, now);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = this.colours.ground;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.front.putOn(context, view);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    for (const robot of robots) this.drawTip(robot);
    for (const robot of robots) if (robot.overlay) this.drawOverlay(robot);
    for (const robot of robots) this.drawLimits(robot, now);
    const chosen = robots.find((robot) => robot.isChosen);
    for (const robot of robots) if (robot !== chosen) this.drawRobot(robot, chosen);
    if (chosen) this.drawRobot(chosen, null);
    return this.isBehind;
  }

  bringUpToDate(robots, now) {
    const { view } = this;
    const key = robots.map(({ name, path, obstacles }) => `${name} ${path.epoch} ${obstacles.length}`).join("|");
    this.adapt(now);
    const stroke = (context, { order }, pen) => this.stroke(context, order, pen);
    const begin = (layer) => {
      layer.begin(view, this.ratio, key, this.colours);
      this.drawGrid(layer);
      for (const { obstacles } of robots) this.drawObstacles(layer, obstacles);
    };
    if (this.front.key === null) begin(this.front);
    const isGood = this.front.key === key && this.front.covers(view);
    if (this.next === null && !isGood) {
      this.next = this.spare;
      begin(this.next);
    } else if (this.next && this.next.key !== key) begin(this.next);
    if (this.front.key === key) this.front.extend(robots, this.budget, stroke);
    if (this.next) {
      this.next.extend(robots, this.budget, stroke);
      // shown as soon as it is complete, and at once where what is shown is of another path
      if (this.next.isComplete || this.front.key !== key) {
        [this.front, this.spare, this.next] = [this.next, this.front, null];
      }
    }
    this.isBehind = this.next !== null || !this.front.isComplete || !this.front.covers(view);
  }

  // As many points in a frame as leave it time enough.
  adapt(now) {
    const took = now - this.before;
    this.before = now;
    if (!this.isBehind) return;
    if (took > SLOW_MS) this.budget = Math.max(LEAST, this.budget / 2);
    else this.budget = Math.min(MOST, this.budget * 1.25);
  }

  stroke(context, order, pen) {
    context.lineJoin = "bevel";
    context.lineCap = "round";
    context.lineWidth = pen ? 2 : 1;
    context.strokeStyle = pen ? this.penColour(order, pen) : this.colours.penUp;
    context.stroke();
  }

  drawGrid(drawn) {
    const { colours } = this;
    const { context } = drawn;
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
        const x = Math.round(drawn.place(n * step, 0)[0]) + 0.5;
        context.moveTo(x, 0);
        context.lineTo(x, drawn.height);
      });
      lines(bottom, top, (n) => {
        if ((n === 0) !== isAxis) return;
        const y = Math.round(drawn.place(0, n * step)[1]) + 0.5;
        context.moveTo(0, y);
        context.lineTo(drawn.width, y);
      });
      context.strokeStyle = isAxis ? colours.axis : colours.grid;
      context.stroke();
    }
  }

  drawObstacles(drawn, obstacles) {
    const { colours } = this;
    const { context } = drawn;
    context.strokeStyle = colours.wall;
    context.fillStyle = colours.wallFill;
    context.lineWidth = 3;
    context.lineCap = "round";
    for (const obstacle of obstacles) {
      context.beginPath();
      if (obstacle.length === 3) {
        const [x, y] = drawn.place(obstacle[0], obstacle[1]);
        context.arc(x, y, obstacle[2] * drawn.scale, 0, 2 * Math.PI);
        context.fill();
      } else {
        context.moveTo(...drawn.place(obstacle[0], obstacle[1]));
        context.lineTo(...drawn.place(obstacle[2], obstacle[3]));
      }
      context.stroke();
    }
  }

  // ---------------------------------------------------------------- what moves

  // What is not in the layer yet: as a rule the last line.
  drawTip({ name, path, order }) {
    const { context, view } = this;
    const last = path.length - 1;
    if (last < 1) return;
    for (let i = Math.max(1, Math.min(last, this.front.counts.get(name) ?? 0), last - TIP); i <= last; i += 1) {
      context.beginPath();
      context.moveTo(...view.toScreen(path.x[i - 1], path.y[i - 1]));
      context.lineTo(...view.toScreen(path.x[i], path.y[i]));
      this.stroke(context, order, path.pen[i]);
    }
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

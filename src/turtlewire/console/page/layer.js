// A picture of what does not move, a little larger than the view: grid, obstacles, paths. It is drawn piece by piece, so
// that no frame takes long, and is only drawn anew when the view leaves it or zooms.

// So much of the view's size is added at each side: panning and following need no redrawing meanwhile.
const RIM = 0.3;
// Points nearer than this to the last one drawn are not seen, pixels.
const FINE = 0.8;
// Lines of one stroke: many short strokes are drawn faster than one with many crossings.
const CHUNK = 200;

export class Layer {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.context = this.canvas.getContext("2d");
    this.key = null;
  }

  // Begin anew, for this view; key: of what is to be drawn.
  begin(view, ratio, key, { ground }) {
    const [width, height] = [Math.round(view.width * (1 + 2 * RIM)), Math.round(view.height * (1 + 2 * RIM))];
    Object.assign(this, { x: view.x, y: view.y, scale: view.scale, width, height, ratio, key });
    this.counts = new Map(); // how many points of each robot's path are drawn
    this.isComplete = false;
    const [deviceWidth, deviceHeight] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== deviceWidth || this.canvas.height !== deviceHeight) {
      this.canvas.width = deviceWidth;
      this.canvas.height = deviceHeight;
    }
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.fillStyle = ground;
    this.context.fillRect(0, 0, width, height);
  }

  // Whether it shows all of the view, at its scale.
  covers(view) {
    return (
      this.scale === view.scale &&
      Math.abs(view.x - this.x) * view.scale <= (this.width - view.width) / 2 &&
      Math.abs(view.y - this.y) * view.scale <= (this.height - view.height) / 2
    );
  }

  place(x, y) {
    return [(x - this.x) * this.scale + this.width / 2, (this.y - y) * this.scale + this.height / 2];
  }

  // Put it where it belongs, in whatever scale the view is now.
  putOn(context, view) {
    const zoom = view.scale / this.scale;
    const left = (this.x - view.x) * view.scale - (this.width * zoom) / 2 + view.width / 2;
    const top = (view.y - this.y) * view.scale - (this.height * zoom) / 2 + view.height / 2;
    const { ratio } = this;
    if (zoom === 1) context.drawImage(this.canvas, Math.round(left * ratio), Math.round(top * ratio));
    else context.drawImage(this.canvas, left * ratio, top * ratio, this.canvas.width * zoom, this.canvas.height * zoom);
  }

  // Draw more of the paths, at most so many points; the last point of each may still move, and is left out.
  extend(robots, points, stroke) {
    let left = points;
    for (const robot of robots) {
      const end = Math.max(0, robot.path.length - 1);
      let at = this.counts.get(robot.name) ?? 0;
      while (at < end && left > 0) {
        const next = this.drawLines(robot.path, Math.max(1, at), Math.min(end, at + left), () => stroke(this.context, robot, robot.path.pen[Math.max(1, at)]));
        left -= next - at;
        at = next;
      }
      this.counts.set(robot.name, at);
    }
    this.isComplete ||= left > 0;
  }

  // One stroke of lines of the same pen, which end at the points from `start` on, before `end`; returns how far it came.
  drawLines(path, start, end, stroke) {
    const { context, scale } = this;
    const [dx, dy] = [this.width / 2 - this.x * scale, this.height / 2 + this.y * scale];
    if (start >= end) return end;
    const pen = path.pen[start];
    context.beginPath();
    let [px, py] = [path.x[start - 1] * scale + dx, dy - path.y[start - 1] * scale];
    context.moveTo(px, py);
    let [i, x, y, drawn, isPending] = [start, px, py, 0, false];
    for (; i < end && drawn < CHUNK && path.pen[i] === pen; i += 1) {
      x = path.x[i] * scale + dx;
      y = dy - path.y[i] * scale;
      isPending = Math.abs(x - px) + Math.abs(y - py) < FINE;
      if (isPending) continue;
      context.lineTo(x, y);
      [px, py] = [x, y];
      drawn += 1;
    }
    if (isPending) context.lineTo(x, y);
    stroke();
    return i;
  }
}

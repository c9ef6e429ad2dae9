// Where on the screen a place on the ground is: millimetres, y up, to pixels, y down. No canvas, no clock.

export const SMALLEST = 0.002; // pixels for each millimetre
export const LARGEST = 20;
const MARGIN = 0.12;

export class View {
  constructor() {
    this.width = 1;
    this.height = 1;
    this.x = 0; // the place in the middle, mm
    this.y = 0;
    this.scale = 0.5;
  }

  toScreen(x, y) {
    return [(x - this.x) * this.scale + this.width / 2, (this.y - y) * this.scale + this.height / 2];
  }

  toGround(px, py) {
    return [(px - this.width / 2) / this.scale + this.x, this.y - (py - this.height / 2) / this.scale];
  }

  // What is under the fingers stays there.
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toGround(px, py);
    this.scale = Math.min(LARGEST, Math.max(SMALLEST, this.scale * factor));
    const [nx, ny] = this.toGround(px, py);
    this.x += x - nx;
    this.y += y - ny;
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  // [left, bottom, right, top]
  fit([left, bottom, right, top]) {
    const [width, height] = [Math.max(right - left, 1), Math.max(top - bottom, 1)];
    const room = 1 - 2 * MARGIN;
    this.scale = Math.min(LARGEST, Math.max(SMALLEST, Math.min((this.width * room) / width, (this.height * room) / height)));
    this.x = (left + right) / 2;
    this.y = (bottom + top) / 2;
  }

  // Moves only as far as it takes to have the place in the middle of the picture, with some room around it.
  follow(x, y) {
    const [roomX, roomY] = [(this.width * 0.22) / this.scale, (this.height * 0.22) / this.scale];
    this.x = Math.min(x + roomX, Math.max(x - roomX, this.x));
    this.y = Math.min(y + roomY, Math.max(y - roomY, this.y));
  }

  // The distance between two lines of the grid: 1, 2 or 5 times a power of ten, and no less than so many pixels.
  spacing(pixels) {
    const least = pixels / this.scale;
    const power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= least * (1 - 1e-9));
  }
}

export function smallestBox(boxes) {
  return boxes
    .filter((box) => box)
    .reduce(
      (one, other) =>
        one
          ? [
              Math.min(one[0], other[0]),
              Math.min(one[1], other[1]),
              Math.max(one[2], other[2]),
              Math.max(one[3], other[3]),
            ]
          : other,
      null,
    );
}

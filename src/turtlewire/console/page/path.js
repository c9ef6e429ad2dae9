// The way that a robot went, as the server tells it: points from an index on replace what was there from that index on.

export class Path {
  constructor() {
    this.generation = null;
    this.x = [];
    this.y = [];
    this.pen = []; // 0: up; else the number of its colour; of the line that ends at this point
    this.settled = 0; // so many points have not changed since the picture of them was begun
    this.version = 0;
  }

  get length() {
    return this.x.length;
  }

  // Takes {generation, from, points}; false: something is missing, the whole path has to be fetched.
  take({ generation, from, points }) {
    if (generation !== this.generation) {
      if (from !== 0) return false;
      this.generation = generation;
      this.truncate(0);
    }
    if (from > this.length) return false;
    this.truncate(from);
    for (const [x, y, pen] of points) {
      this.x.push(x);
      this.y.push(y);
      this.pen.push(pen);
    }
    this.version += 1;
    return true;
  }

  truncate(length) {
    this.x.length = this.y.length = this.pen.length = length;
    this.settled = Math.min(this.settled, length);
  }

  // The smallest box around what was drawn, and around where the robot went: [left, bottom, right, top], or null.
  box() {
    if (!this.length) return null;
    let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < this.length; i += 1) {
      left = Math.min(left, this.x[i]);
      right = Math.max(right, this.x[i]);
      bottom = Math.min(bottom, this.y[i]);
      top = Math.max(top, this.y[i]);
    }
    return [left, bottom, right, top];
  }
}

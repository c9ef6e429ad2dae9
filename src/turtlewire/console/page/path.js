// The way that a robot went, on the common ground, as the server tells it: points from an index on replace what was there from that index on.

import { placer } from "./ground.js";

export class Path {
  constructor() {
    this.generation = null;
    this.place = placer(null);
    this.x = [];
    this.y = [];
    this.pen = []; // 0: up; else the number of its colour; of the line that ends at this point
    this.epoch = 0; // of the points that are not the last: another one where any of them changed
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
    for (const [ownX, ownY, pen] of points) {
      const [x, y] = this.place(ownX, ownY);
      this.x.push(x);
      this.y.push(y);
      this.pen.push(pen);
    }
    return true;
  }

  // Its points have to be taken anew after that.
  setOrigin(origin) {
    this.place = placer(origin);
    this.generation = null;
    this.truncate(0);
  }

  truncate(length) {
    if (length < this.length - 1) this.epoch += 1;
    this.x.length = this.y.length = this.pen.length = length;
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

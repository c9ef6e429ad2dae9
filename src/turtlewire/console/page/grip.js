// What is held just now, and the set-points that come of it: the dead-man's handle.
//
// Keys, the joystick, a gamepad and buttons are sources: each presses, changes and releases. While any of them is held a
// timer sends set-points, and what begins to move, or stands, is sent at once; when the last is released, or whatever else ends the grip, nothing is sent any more. A grip
// that was ended (a stop, an error, a window that lost the focus) does not come back: its sources count again only after
// a new press, and that press has a new number.

export const PERIOD_MS = 1000 / 30;
// The server drops what is older than 300 ms; who hears nothing for so long while driving does not drive any more.
export const DEAF_MS = 1000;
// What is driven and turned at once is an arc, rather than a turn around one wheel.
const ARC = 0.5;

// What a limit is told as first.
const UNEXPLAINED = new Set(["stopped", "ended"]);

export class Grip {
  // api: see api.js; changed: called after every change, for the page to show it.
  constructor(api, changed = () => {}) {
    this.api = api;
    this.changed = changed;
    this.robot = null;
    this.combines = true;
    this.steers = false;
    this.limits = { speed: 0.5, turn: 0.5 };
    this.sources = new Map();
    this.grips = 0;
    this.number = 0;
    this.ended = null; // why the last grip ended by itself: a code
    this.timer = null;
    this.since = 0;
    this.moves = false; // what was sent last
  }

  get isHeld() {
    return this.sources.size > 0;
  }

  // what: {speed, turn} as -1..1, {horn: true}; `analog` of what tells its strength itself.
  press(source, what) {
    const begins = !this.isHeld;
    this.sources.delete(source); // the newest counts most
    this.sources.set(source, what);
    if (begins) {
      this.grips += 1;
      this.ended = null;
      this.since = performance.now();
      this.sendNow();
    } else this.sendIfItMatters();
    this.changed();
  }

  // A source that is not held any more is none: it has to press again.
  change(source, what) {
    if (!this.sources.has(source)) return;
    this.sources.set(source, what);
    this.sendIfItMatters();
    this.changed();
  }

  release(source) {
    if (!this.sources.delete(source)) return;
    if (this.isHeld) {
      this.sendIfItMatters();
      this.changed();
    } else this.rest(null);
  }

  // Whatever is held does not count any more; why: a code, or null where the person knows anyway.
  letGo(why = null) {
    if (!this.isHeld) {
      // that it was ended may be told before why
      if (why === "limit" && UNEXPLAINED.has(this.ended)) {
        this.ended = why;
        this.changed();
      }
      return;
    }
    this.sources.clear();
    this.rest(why);
  }

  rest(why) {
    clearInterval(this.timer);
    this.timer = null;
    this.ended = why;
    if (this.robot !== null) this.api.send({ type: "release", robot: this.robot });
    this.changed();
  }

  setRobot(robot) {
    if (robot === this.robot) return;
    this.letGo();
    this.robot = robot;
    this.ended = null;
    this.changed();
  }

  // What is wished now: {speed, turn, horn}, within the limits.
  wish() {
    let [speed, turn, horn, analog, newest] = [0, 0, false, false, null];
    for (const what of this.sources.values()) {
      if (what.speed) [speed, newest] = [what.speed, "speed"];
      if (what.turn) [turn, newest] = [what.turn, what.speed ? newest : "turn"];
      if (what.horn) horn = true;
      if (what.analog) analog = true;
    }
    if (!this.combines && speed && turn) {
      if (analog ? Math.abs(speed) >= Math.abs(turn) : newest === "speed") turn = 0;
      else speed = 0;
    }
    if (!this.steers) turn *= this.limits.turn * (speed && !analog ? ARC : 1);
    return { speed: speed * this.limits.speed, turn, horn };
  }

  // A finger that is put down and pushed does not wait for the timer; what only changes its strength does.
  sendIfItMatters() {
    const { speed, turn } = this.wish();
    if ((speed !== 0 || turn !== 0) !== this.moves) this.sendNow();
  }

  sendNow() {
    clearInterval(this.timer);
    this.timer = setInterval(() => this.send(), PERIOD_MS);
    this.send();
  }

  send() {
    const { api } = this;
    if (this.robot === null) return;
    if (!api.isOpen || Math.min(api.age_ms, performance.now() - this.since) > DEAF_MS) {
      this.letGo("connection");
      return;
    }
    this.number += 1;
    const wish = this.wish();
    this.moves = wish.speed !== 0 || wish.turn !== 0;
    api.send({
      type: "drive",
      robot: this.robot,
      number: this.number,
      grip: this.grips,
      ...wish,
      stamp: api.stamp,
      age_ms: Math.round(api.age_ms),
    });
  }
}

// What the link did over the last minutes: once a second, the differences of the counters of its figures.

export const KEPT = 300;
export const PERIOD_MS = 1000;

// Figures of the connection that tell of something that went wrong and was mended, see the robots' statistics.
const RECOVERIES = [
  "retries",
  "fences_lost",
  "malformed_replies",
  "unexpected_replies",
  "frames_ignored",
  "frames_lost",
  "reconnections",
];

export function recoveries(figures) {
  return RECOVERIES.reduce((sum, name) => sum + (figures[name] ?? 0), 0);
}

export class Samples {
  constructor() {
    this.rows = []; // {at, round_trip_ms, recoveries, sent, received}: per second
    this.before = null;
  }

  // figures: of the robot's connection; time_s: the robot's link's clock.
  add(figures, time_s) {
    const now = {
      time_s,
      sent: figures.bytes_sent ?? 0,
      received: figures.bytes_received ?? 0,
      recoveries: recoveries(figures),
    };
    const { before } = this;
    this.before = now;
    if (!before || now.time_s <= before.time_s) return;
    const passed = now.time_s - before.time_s;
    const rate = (name) => Math.max(0, now[name] - before[name]) / passed;
    this.rows.push({
      at: now.time_s,
      round_trip_ms: figures.round_trip_median_s == null ? null : figures.round_trip_median_s * 1000,
      longest_ms: figures.round_trip_max_s == null ? null : figures.round_trip_max_s * 1000,
      recoveries: Math.max(0, now.recoveries - before.recoveries),
      sent: rate("sent"),
      received: rate("received"),
    });
    if (this.rows.length > KEPT) this.rows.shift();
  }
}

// What passed on a wire, as a page keeps it: bounded, filtered, and held still while somebody reads.

export const MAX_LINES = 5000;

export class Lines {
  constructor() {
    this.filter = { sender: "", kind: "", name: "", text: "" };
    this.reset();
  }

  // Another wire: its numbers begin anew.
  reset() {
    this.held = null;
    this.clear(-1);
  }

  // Nothing is kept of what was there up to a number.
  clear(floor = this.last) {
    this.floor = floor;
    this.all = []; // what is kept, the oldest first
    this.held &&= []; // what has come since somebody paused
    this.heldLost = 0;
    this.shown = [];
    this.names = new Set();
    this.dropped = 0; // how many of the shown ones were dropped at the beginning, ever
  }

  get isPaused() {
    return this.held !== null;
  }

  get waiting() {
    return this.held ? this.held.length + this.heldLost : 0;
  }

  get last() {
    const from = this.held?.length ? this.held : this.all;
    return from.length ? from[from.length - 1].number : this.floor;
  }

  pause() {
    this.held ??= [];
  }

  goOn() {
    const { held, heldLost } = this;
    this.held = null;
    this.heldLost = 0;
    if (held) this.add(held, heldLost);
  }

  // New lines, and how many there were between the last ones and these that nobody has.
  add(lines, lost = 0) {
    const last = this.last;
    const fresh = lines.filter((line) => line.number > last);
    if (!fresh.length) return;
    if (this.held) {
      this.heldLost += lost;
      this.held.push(...fresh);
      const over = this.held.length - MAX_LINES;
      if (over > 0) {
        this.held.splice(0, over);
        this.heldLost += over;
      }
      return;
    }
    if (lost > 0 && last >= 0) {
      const { number, time_s } = fresh[0];
      fresh.unshift({ number: number - 0.5, time_s, from: null, offset: 0, raw: "", kind: "gap", lost, text: "", names: [] });
    }
    for (const line of fresh) for (const name of line.names) this.names.add(name);
    this.all.push(...fresh);
    this.shown.push(...fresh.filter((line) => this.fits(line)));
    const over = this.all.length - MAX_LINES;
    if (over > 0) {
      const oldest = this.all[over].number;
      this.all.splice(0, over);
      const gone = this.shown.findIndex((line) => line.number >= oldest);
      const count = gone < 0 ? this.shown.length : gone;
      this.shown.splice(0, count);
      this.dropped += count;
    }
  }

  fits(line) {
    const { sender, kind, name, text } = this.filter;
    if (sender && line.from !== sender) return false;
    if (kind === "error" && line.kind !== "error") return false;
    if (name && !line.names.includes(name)) return false;
    if (!text) return true;
    const sought = text.toLowerCase();
    return line.text.toLowerCase().includes(sought) || line.raw.toLowerCase().includes(sought);
  }

  refilter() {
    this.shown = this.all.filter((line) => this.fits(line));
    this.dropped = 0;
  }

  // As `turtlewire decode` prints a recording.
  asText(lines = this.shown) {
    return lines
      .map((line) => {
        const head = `${line.time_s.toFixed(6).padStart(12)}  `;
        if (line.kind === "gap" || line.kind === "note") return `${head}# ${line.text || `${line.lost} lines are missing`}\n`;
        const says = line.kind === "message" ? line.text : `${line.kind}: ${line.text}`;
        return `${head}${line.from.padEnd(5)}  ${String(line.offset).padStart(8)}  ${says.padEnd(48)}  # ${line.raw}\n`;
      })
      .join("");
  }
}

// Works over plain http, too, which is no secure context: there is no clipboard of the newer kind there.
export function copy(text) {
  const area = Object.assign(document.createElement("textarea"), { value: text, readOnly: true });
  area.style.cssText = "position: fixed; top: 0; left: 0; opacity: 0";
  const focused = document.activeElement;
  document.body.append(area);
  area.select();
  const isDone = document.execCommand("copy");
  area.remove();
  focused?.focus?.();
  return isDone;
}

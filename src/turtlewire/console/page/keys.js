// The keyboard: which keys drive, which do something once, and to whom a key belongs while something has the focus.

const ARROWS = {
  ArrowUp: { speed: 1 },
  ArrowDown: { speed: -1 },
  ArrowLeft: { turn: -1 },
  ArrowRight: { turn: 1 },
};

// By place on the keyboard (KeyW), so that WASD is where it should be on any; by what it types (key) for WALTER's own
// keys, which are letters of its protocol, section 3. Arrows do in each of them.
export const LAYOUTS = {
  arrows: { codes: ARROWS, keys: {}, does: {} },
  wasd: {
    codes: { ...ARROWS, KeyW: ARROWS.ArrowUp, KeyS: ARROWS.ArrowDown, KeyA: ARROWS.ArrowLeft, KeyD: ARROWS.ArrowRight },
    keys: {},
    does: {},
  },
  walter: {
    codes: ARROWS,
    keys: { a: ARROWS.ArrowUp, z: ARROWS.ArrowDown, ",": ARROWS.ArrowLeft, ".": ARROWS.ArrowRight },
    does: {
      s: "pen_up",
      x: "pen_down",
      d: "speed_more",
      c: "speed_less",
      f: "turn_more",
      v: "turn_less",
      g: "ask_speed",
      b: "ask_turn",
    },
  },
  none: { codes: {}, keys: {}, does: {} },
};
const DOES = { l: "lamp", p: "pen", r: "resume", "+": "faster", "=": "faster", "-": "slower" };
// These come again while they are held.
const REPEATS = new Set(["speed_more", "speed_less", "turn_more", "turn_less", "faster", "slower"]);

const TEXT_TYPES = new Set(["text", "search", "url", "tel", "email", "password", "number", "date", "time"]);

export function isTextField(element) {
  if (!element) return false;
  if (element.isContentEditable || element.tagName === "TEXTAREA") return true;
  return element.tagName === "INPUT" && TEXT_TYPES.has(element.type);
}

// Whether what has the focus needs this key for itself.
function ownsKey(element, key) {
  if (!element) return false;
  if (key === " ") return element.matches("input[type=checkbox], input[type=radio], select");
  if (key.startsWith("Arrow")) {
    return element.matches("input[type=range], input[type=radio], select, [role=tab], [data-own-arrows]");
  }
  if (key === "+" || key === "-" || key === "=") return element.matches("[data-own-arrows]");
  return element.matches("select");
}

export class Keys {
  // grip: see grip.js; stop(), act(name, value): what is to be done; layout(): the name of one; isBusy(): a dialog is open.
  constructor({ grip, stop, act, layout, isBusy }) {
    Object.assign(this, { grip, stop, act, layout, isBusy });
    this.listen = [
      [window, "keydown", (event) => this.down(event)],
      [window, "keyup", (event) => this.up(event)],
    ];
  }

  start() {
    // before whatever else there is: an editor or a dialog must not swallow Escape
    for (const [target, type, listener] of this.listen) target.addEventListener(type, listener, true);
  }

  end() {
    for (const [target, type, listener] of this.listen) target.removeEventListener(type, listener, true);
  }

  down(event) {
    const { key, target } = event;
    const isTyping = isTextField(target);
    if (key === "Escape" || (key === " " && !isTyping && (this.grip.isHeld || !ownsKey(target, key)))) {
      if (!event.repeat) this.stop();
      if (key === " ") event.preventDefault();
      return;
    }
    // some systems tell no releases while such a key is held
    if (key === "Meta" || key === "OS") this.grip.letGo("blur");
    if (isTyping || event.ctrlKey || event.altKey || event.metaKey || this.isBusy() || ownsKey(target, key)) return;
    const name = this.layout();
    const layout = LAYOUTS[name];
    const letter = key.length === 1 ? key.toLowerCase() : key;
    const moves = layout.codes[event.code] ?? layout.keys[letter];
    if (moves) {
      event.preventDefault();
      if (!event.repeat) this.grip.press(`key ${event.code}`, moves);
      return;
    }
    if (name === "none") return;
    if (letter === "h") {
      if (!event.repeat) this.grip.press(`key ${event.code}`, { horn: true });
      return;
    }
    if (/^[1-9]$/.test(letter)) {
      this.act("speed", Number(letter) / 9);
      return;
    }
    const does = layout.does[letter] ?? DOES[letter];
    if (does && (!event.repeat || REPEATS.has(does))) {
      event.preventDefault(); // G and B go to a field, and must not be typed there
      this.act(does);
    }
  }

  up(event) {
    if (event.key === " " && !isTextField(event.target) && !ownsKey(event.target, " ")) event.preventDefault();
    this.grip.release(`key ${event.code}`);
  }
}

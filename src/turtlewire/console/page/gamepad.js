// A gamepad, as the browser tells it: the left stick drives. It has to be let go of once before it counts.

export const DEAD = 0.15;
const PERIOD_MS = 1000 / 30;
const SOURCE = "gamepad";
const BUTTONS = { 1: "stop", 2: "lamp", 3: "pen" };
const HORN = 0;

// Without the dead zone: 0 within it, from there to 1 in proportion.
export function live(value) {
  const size = Math.abs(value);
  if (size <= DEAD) return 0;
  return Math.sign(value) * Math.min(1, (size - DEAD) / (1 - DEAD));
}

export class Gamepads {
  // changed(name): which gamepad there is, or null.
  constructor({ grip, stop, act, changed }) {
    Object.assign(this, { grip, stop, act, changed });
    this.index = null;
    this.isArmed = false;
    this.pressed = new Set();
    this.timer = null;
    this.connect = ({ gamepad }) => this.take(gamepad);
    this.disconnect = ({ gamepad }) => {
      if (gamepad.index === this.index) this.lose();
    };
  }

  start() {
    window.addEventListener("gamepadconnected", this.connect);
    window.addEventListener("gamepaddisconnected", this.disconnect);
  }

  end() {
    window.removeEventListener("gamepadconnected", this.connect);
    window.removeEventListener("gamepaddisconnected", this.disconnect);
    this.lose();
  }

  take(gamepad) {
    if (this.index !== null) return;
    this.index = gamepad.index;
    this.isArmed = false;
    this.changed(gamepad.id);
    this.timer = setInterval(() => this.look(), PERIOD_MS);
  }

  lose() {
    clearInterval(this.timer);
    this.timer = null;
    this.index = null;
    this.pressed.clear();
    this.grip.release(SOURCE);
    this.grip.release(`${SOURCE} horn`);
    this.changed(null);
  }

  look() {
    const gamepad = navigator.getGamepads()[this.index];
    if (!gamepad?.connected) {
      this.lose();
      return;
    }
    const [turn, speed] = [live(gamepad.axes[0] ?? 0), -live(gamepad.axes[1] ?? 0)];
    if (!turn && !speed) {
      this.isArmed = true;
      this.grip.release(SOURCE);
    } else if (this.grip.sources.has(SOURCE)) {
      this.grip.change(SOURCE, { speed, turn, analog: true });
    } else if (this.isArmed) {
      this.isArmed = false; // one press for each time that it leaves the middle
      this.grip.press(SOURCE, { speed, turn, analog: true });
    }
    gamepad.buttons.forEach((button, index) => this.button(index, button.pressed));
  }

  button(index, isPressed) {
    if (isPressed === this.pressed.has(index)) return;
    if (isPressed) this.pressed.add(index);
    else this.pressed.delete(index);
    if (index === HORN) {
      if (isPressed) this.grip.press(`${SOURCE} horn`, { horn: true });
      else this.grip.release(`${SOURCE} horn`);
    } else if (isPressed && BUTTONS[index] === "stop") this.stop();
    else if (isPressed && BUTTONS[index]) this.act(BUTTONS[index]);
  }
}

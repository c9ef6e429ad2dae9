// The client of the server's documented API: the stream (a WebSocket), requests, and what is known of the robots.
//
// Whatever the page does goes through here. `store` is reactive; paths are not, because they are long and are drawn by
// a loop of their own.

import { reactive } from "vue";
import { Path } from "./path.js";

// How long to wait before the stream is opened again, and so on up to the last.
const AGAIN_MS = [250, 500, 1000, 2000, 3000];
const TOAST_MS = 6000;
const MAX_TOASTS = 4;

export class ApiError extends Error {
  constructor(status, code, text, details = null) {
    super(text);
    this.status = status;
    this.code = code;
    this.text = text;
    this.details = details;
  }
}

export class Api {
  constructor(base = "") {
    this.base = base;
    this.store = reactive({
      connection: "connecting", // open, lost
      session: null, // a secret of this page's, for requests
      id: null, // what others know it by
      name: "",
      robots: {},
      order: [],
      toasts: [],
    });
    this.paths = new Map();
    this.overlays = new Map();
    this.listeners = new Map();
    this.stamp = null;
    this.stampedAt = 0;
    this.socket = null;
    this.attempts = 0;
    this.toasted = 0;
    this.fetching = new Set();
    this.closed = false;
  }

  // ---------------------------------------------------------------- the stream

  open() {
    this.closed = false;
    const url = new URL(`${this.base}/api/stream`, window.location.href);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(url);
    this.socket = socket;
    socket.onmessage = ({ data }) => {
      if (socket === this.socket) this.receive(JSON.parse(data));
    };
    socket.onclose = () => {
      if (socket !== this.socket || this.closed) return;
      this.socket = null;
      this.store.connection = "lost";
      this.stamp = null;
      for (const robot of Object.values(this.store.robots)) robot.drives = false;
      this.tell("lost", {});
      const wait = AGAIN_MS[Math.min(this.attempts, AGAIN_MS.length - 1)];
      this.attempts += 1;
      clearTimeout(this.again);
      this.again = setTimeout(() => this.open(), wait * (0.75 + Math.random() / 2));
    };
  }

  close() {
    this.closed = true;
    clearTimeout(this.again);
    this.socket?.close();
    this.socket = null;
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  // False: the stream is not open, and nothing was kept for later.
  send(message) {
    if (!this.isOpen) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  // How long ago the newest message of the server was received, in milliseconds.
  get age_ms() {
    return this.stamp === null ? Infinity : performance.now() - this.stampedAt;
  }

  receive(message) {
    if (message.stamp !== undefined) {
      this.stamp = message.stamp;
      this.stampedAt = performance.now();
    }
    if (message.type === "welcome") this.welcome(message);
    else if (message.type === "robots") this.meet(message.robots);
    else if (message.type === "state") this.see(message);
    this.tell(message.type, message);
  }

  welcome({ session, id, name, robots }) {
    this.attempts = 0;
    this.store.session = session;
    this.store.id = id;
    this.store.name = name ?? "";
    this.meet(robots);
    this.store.connection = "open";
    this.send({ type: "visible", visible: !document.hidden });
    // What was missed is not told again: see the paths anew.
    for (const robot of this.store.order) {
      this.send({ type: "watch", robot });
      this.fetchPath(robot);
    }
  }

  meet(robots) {
    const { store } = this;
    store.order = robots.map((robot) => robot.name);
    for (const info of robots) {
      const known = store.robots[info.name];
      const isMoved = JSON.stringify(known?.info.origin ?? null) !== JSON.stringify(info.origin ?? null);
      if (known) known.info = info;
      else {
        store.robots[info.name] = {
          info,
          view: null,
          wheel: null,
          program: null,
          faults: null,
          refused: null,
          drives: false,
        };
        this.paths.set(info.name, new Path());
        if (store.connection === "open") this.send({ type: "watch", robot: info.name });
      }
      if (isMoved) {
        this.paths.get(info.name).setOrigin(info.origin);
        if (store.connection === "open") this.fetchPath(info.name);
      }
    }
    for (const name of Object.keys(store.robots)) {
      if (!store.order.includes(name)) delete store.robots[name];
    }
  }

  see({ robot, view, wheel, program, faults, path, refused }) {
    const known = this.store.robots[robot];
    if (!known) return;
    if (view !== undefined) known.view = view;
    if (program !== undefined) known.program = program;
    if (faults !== undefined) known.faults = faults;
    if (refused !== undefined) known.refused = refused;
    if (wheel !== undefined) {
      known.wheel = wheel;
      known.drives = wheel?.driver != null && wheel.driver === this.store.id;
    }
    if (path && !this.paths.get(robot).take(path)) this.fetchPath(robot);
  }

  async fetchPath(robot) {
    if (this.fetching.has(robot)) return;
    this.fetching.add(robot);
    try {
      const path = await this.request("GET", `/api/robots/${encodeURIComponent(robot)}/path?since=0`);
      this.paths.get(robot)?.take(path);
      this.tell("path", { robot });
    } catch {
      // the stream says when the server is away, and after that all is fetched again
    } finally {
      this.fetching.delete(robot);
    }
  }

  // ---------------------------------------------------------------- listeners

  on(type, listener) {
    if (!this.listeners.has(type)) this.listeners.set(type, new Set());
    this.listeners.get(type).add(listener);
    return () => this.listeners.get(type).delete(listener);
  }

  tell(type, message) {
    for (const listener of this.listeners.get(type) ?? []) listener(message);
  }

  // ---------------------------------------------------------------- requests

  async request(method, path, body, more = {}) {
    const headers = { ...more };
    if (this.store.session) headers["X-Session"] = this.store.session;
    if (body !== undefined) headers["Content-Type"] = "application/json";
    let response;
    try {
      response = await fetch(this.base + path, {
        method,
        headers,
        body: body === undefined ? undefined : JSON.stringify(body),
        credentials: "same-origin",
        cache: "no-store",
      });
    } catch (error) {
      throw new ApiError(0, "unreachable", String(error));
    }
    const text = await response.text();
    let answer = null;
    try {
      answer = text ? JSON.parse(text) : null;
    } catch {
      answer = { text };
    }
    if (!response.ok) throw new ApiError(response.status, answer?.code ?? "refused", answer?.text ?? response.statusText, answer?.details);
    return answer;
  }

  // Anyone may stop a robot, or all of them (null). Both ways at once: whichever is there first.
  stop(robot = null) {
    this.tell("stopping", { robot });
    this.send({ type: "stop", robot });
    const path = robot === null ? "/api/stop" : `/api/robots/${encodeURIComponent(robot)}/stop`;
    // the session tells that it is one's own: somebody else's stop takes the wheel away for good
    const headers = this.store.session ? { "X-Session": this.store.session } : {};
    return fetch(this.base + path, { method: "POST", headers, credentials: "same-origin", keepalive: true }).then(
      (response) => response.ok,
      () => false,
    );
  }

  wheel(robot, action, to) {
    return this.send({ type: "wheel", robot, action, ...(to ? { to } : {}) });
  }

  // As a new press does: not where somebody's stop took it away.
  async takeFreeWheel(robot) {
    const wheel = this.store.robots[robot]?.wheel;
    if (wheel?.driver != null || wheel?.barred.includes(this.store.id)) return;
    await this.request("POST", `/api/robots/${encodeURIComponent(robot)}/wheel`, { action: "take" });
  }

  command(robot, command, value) {
    return this.request("POST", `/api/robots/${encodeURIComponent(robot)}/commands`, {
      command,
      ...(value === undefined ? {} : { value }),
    });
  }

  // ---------------------------------------------------------------- people

  // Says something in passing; level: note, good, warning or error.
  say(level, text) {
    const { toasts } = this.store;
    const same = toasts.find((toast) => toast.text === text && toast.level === level);
    if (same) {
      same.times += 1;
      this.forgetLater(same);
      return;
    }
    this.toasted += 1;
    toasts.push({ id: this.toasted, level, text, times: 1 });
    while (toasts.length > MAX_TOASTS) toasts.shift();
    this.forgetLater(toasts[toasts.length - 1]);
  }

  forgetLater(toast) {
    clearTimeout(toast.timer);
    toast.timer = setTimeout(() => this.forget(toast.id), toast.level === "error" ? 2 * TOAST_MS : TOAST_MS);
  }

  forget(id) {
    const at = this.store.toasts.findIndex((toast) => toast.id === id);
    if (at >= 0) this.store.toasts.splice(at, 1);
  }

  // Strokes ([{pen, points}]) to be drawn dashed on the map, of what a robot would do; null: none.
  overlay(robot, strokes) {
    if (strokes) this.overlays.set(robot, strokes);
    else this.overlays.delete(robot);
    this.tell("overlay", { robot });
  }
}

// The map: where the robots are, where they went, what is in their way.

import { placedObstacle, placedPose, placer } from "./ground.js";
import { length, Painter } from "./painter.js";
import { smallestBox } from "./view.js";

// A robot glides from where it was seen to where it is seen now.
const GLIDE_MS = 70;
const EMPTY_MM = 500;
const PAN_PX = 60;
const ZOOM = 1.4;
const WHEEL = 0.0016;

const colour = (style, name) => style.getPropertyValue(name).trim();

export default {
  props: { api: Object, robot: String, theme: String, t: Function },
  data: () => ({ follows: true, isFitted: true, saves: false, scale: { width: 0, text: "" } }),

  computed: {
    chosen() {
      return this.api.store.robots[this.robot];
    },
    description() {
      const pose = this.chosen?.view?.pose;
      if (!pose) return this.t("map");
      const [x, y, heading] = [pose.x_mm, pose.y_mm, pose.heading_deg].map((value) => Math.round(value));
      return this.t("map_says", { robot: this.chosen.info.title, x, y, heading });
    },
    picture() {
      return `${this.api.base}/api/robots/${encodeURIComponent(this.robot)}/picture`;
    },
  },

  watch: {
    theme() {
      this.$nextTick(() => this.recolour());
    },
    robot() {
      if (this.isFitted) this.fit();
      this.wake();
    },
  },

  mounted() {
    this.painter = new Painter(this.$refs.canvas);
    this.shown = new Map(); // name -> {x, y, heading}
    this.limits = new Map(); // name -> [{x, y, since}]
    this.placed = new Map(); // name -> {info, obstacles}
    this.pointers = new Map();
    this.frame = 0;
    this.before = 0;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.$refs.frame);
    this.media = window.matchMedia("(prefers-color-scheme: dark)");
    this.recolourLater = () => this.$nextTick(() => this.recolour());
    this.media.addEventListener("change", this.recolourLater);
    this.calm = window.matchMedia("(prefers-reduced-motion: reduce)");
    this.off = ["state", "welcome", "robots", "overlay"].map((type) => this.api.on(type, () => this.wake()));
    // what was there before this page came
    this.off.push(this.api.on("path", () => (this.isFitted ? this.fit() : this.wake())));
    this.off.push(this.api.on("limit", (limit) => this.markLimit(limit)));
    this.recolour();
    this.resize();
  },

  beforeUnmount() {
    cancelAnimationFrame(this.frame);
    this.observer.disconnect();
    this.media.removeEventListener("change", this.recolourLater);
    for (const off of this.off) off();
  },

  methods: {
    recolour() {
      const style = getComputedStyle(this.$refs.frame);
      this.painter.setColours({
        isDark: document.body.classList.contains("body--dark"),
        ground: colour(style, "--map-ground"),
        grid: colour(style, "--map-grid"),
        axis: colour(style, "--map-axis"),
        wall: colour(style, "--map-wall"),
        wallFill: colour(style, "--map-wall-fill"),
        penUp: colour(style, "--map-pen-up"),
        preview: colour(style, "--map-preview"),
        ink: colour(style, "--ink"),
        muted: colour(style, "--muted"),
        danger: colour(style, "--danger"),
        off: colour(style, "--map-off"),
      });
      this.wake();
    },

    resize() {
      const { clientWidth, clientHeight } = this.$refs.frame;
      this.painter.resize(clientWidth, clientHeight, window.devicePixelRatio || 1);
      if (this.isFitted) this.fit();
      this.wake();
    },

    markLimit({ robot, x: ownX, y: ownY }) {
      const [x, y] = placer(this.api.store.robots[robot].info.origin)(ownX, ownY);
      this.limits.set(robot, [...(this.limits.get(robot) ?? []).slice(-3), { x, y, since: performance.now() }]);
      this.wake();
    },

    // -------------------------------------------------------------- frames

    wake() {
      if (!this.frame && this.painter) this.frame = requestAnimationFrame((now) => this.draw(now));
    },

    draw(now) {
      this.frame = 0;
      const passed = Math.min(100, now - this.before);
      this.before = now;
      let moves = false;
      const robots = this.api.store.order.map((name, order) => {
        const { info, view } = this.api.store.robots[name];
        moves = this.glide(name, view && placedPose(info.origin, view.pose), passed) || moves;
        return {
          name,
          order,
          label: this.api.store.order.length > 1 ? info.name : "",
          isChosen: name === this.robot,
          link: view?.link,
          pose: this.shown.get(name),
          path: this.api.paths.get(name),
          obstacles: this.obstacles(info),
          overlay: this.overlay(name, info),
          limits: this.limits.get(name) ?? [],
        };
      });
      const chosen = this.shown.get(this.robot);
      if (this.follows && chosen && this.pointers.size === 0) this.painter.view.follow(chosen.x, chosen.y);
      const isBehind = this.painter.paint(robots, performance.now());
      const { step, view } = this.painter;
      const width = Math.round(step * view.scale);
      if (width !== this.scale.width || length(step) !== this.scale.text) this.scale = { width, text: length(step) };
      if (moves || isBehind || this.painter.isShowingLimit(robots, performance.now())) this.wake();
    },

    obstacles(info) {
      if (this.placed.get(info.name)?.info !== info) {
        const obstacles = (info.obstacles ?? []).map((each) => placedObstacle(info.origin, each));
        this.placed.set(info.name, { info, obstacles });
      }
      return this.placed.get(info.name).obstacles;
    },

    overlay(name, { origin }) {
      const place = placer(origin);
      return this.api.overlays.get(name)?.map(({ pen, points }) => ({ pen, points: points.map(([x, y]) => place(x, y)) }));
    },

    // Whether the robot is still on its way to where it is.
    glide(name, goal, passed) {
      if (!goal) return false;
      const shown = this.shown.get(name);
      if (!shown || this.calm.matches) {
        this.shown.set(name, goal);
        return false;
      }
      const part = 1 - Math.exp((-2 * passed) / GLIDE_MS);
      const turn = ((goal.heading - shown.heading + 540) % 360) - 180;
      const [dx, dy] = [goal.x - shown.x, goal.y - shown.y];
      if (Math.abs(dx) + Math.abs(dy) < 0.05 && Math.abs(turn) < 0.05) {
        this.shown.set(name, goal);
        return false;
      }
      this.shown.set(name, { x: shown.x + dx * part, y: shown.y + dy * part, heading: shown.heading + turn * part });
      return true;
    },

    // -------------------------------------------------------------- the view

    fit() {
      const around = (x, y, r) => [x - r, y - r, x + r, y + r];
      const boxOf = (o) =>
        o.length === 3 ? around(...o) : [Math.min(o[0], o[2]), Math.min(o[1], o[3]), Math.max(o[0], o[2]), Math.max(o[1], o[3])];
      const boxes = this.api.store.order.flatMap((name) => {
        const { info, view } = this.api.store.robots[name];
        const isChosen = name === this.robot;
        const pose = view && placedPose(info.origin, view.pose);
        const robot = pose ? around(pose.x, pose.y, isChosen ? EMPTY_MM / 2 : 100) : null;
        return isChosen ? [robot, this.api.paths.get(name).box(), ...this.obstacles(info).map(boxOf)] : [robot];
      });
      this.painter.view.fit(smallestBox(boxes) ?? [-EMPTY_MM, -EMPTY_MM, EMPTY_MM, EMPTY_MM]);
      this.isFitted = true;
      this.wake();
    },

    zoom(factor, px, py) {
      this.painter.view.zoom(factor, px, py);
      this.isFitted = false;
      this.wake();
    },

    pan(dx, dy) {
      this.painter.view.pan(dx, dy);
      this.isFitted = this.follows = false;
      this.wake();
    },

    toggleFollow() {
      this.follows = !this.follows;
      this.wake();
    },

    // -------------------------------------------------------------- hands

    place(event) {
      const box = this.$refs.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    },

    down(event) {
      this.saves = false;
      this.$refs.canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, this.place(event));
    },

    move(event) {
      const before = this.pointers.get(event.pointerId);
      if (!before) return;
      const now = this.place(event);
      if (this.pointers.size === 1) this.pan(now[0] - before[0], now[1] - before[1]);
      else if (this.pointers.size === 2) {
        const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = (one) => Math.hypot(one[0] - other[0], one[1] - other[1]);
        const middle = (one) => [(one[0] + other[0]) / 2, (one[1] + other[1]) / 2];
        const [from, to] = [middle(before), middle(now)];
        if (apart(before) > 1) this.zoom(apart(now) / apart(before), ...from);
        this.pan(to[0] - from[0], to[1] - from[1]);
      }
      this.pointers.set(event.pointerId, now);
    },

    up(event) {
      this.pointers.delete(event.pointerId);
      this.wake();
    },

    wheel(event) {
      const lines = event.deltaMode === 1 ? 16 : 1;
      this.zoom(Math.exp(-event.deltaY * lines * WHEEL), ...this.place(event));
    },

    key(event) {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const does = {
        ArrowLeft: () => this.pan(PAN_PX, 0),
        ArrowRight: () => this.pan(-PAN_PX, 0),
        ArrowUp: () => this.pan(0, PAN_PX),
        ArrowDown: () => this.pan(0, -PAN_PX),
        "+": () => this.zoom(ZOOM),
        "=": () => this.zoom(ZOOM),
        "-": () => this.zoom(1 / ZOOM),
        0: () => this.fit(),
      }[event.key];
      if (!does) return;
      event.preventDefault();
      does();
    },
  },

  template: `
    <section class="tw-map" ref="frame" :aria-label="t('map')">
      <canvas ref="canvas" tabindex="0" role="application" data-own-arrows
        :aria-label="description" :aria-description="t('map_keys')" :title="t('map_keys')"
        @pointerdown="down" @mousedown.prevent @pointermove="move" @pointerup="up" @pointercancel="up"
        @wheel.prevent="wheel" @keydown="key"></canvas>
      <div class="tw-map-tools" role="group" :aria-label="t('map_tools')">
        <button class="tw-tool" :aria-label="t('zoom_in')" :title="t('zoom_in')" @click="zoom(1.4)"><tw-icon name="plus"/></button>
        <button class="tw-tool" :aria-label="t('zoom_out')" :title="t('zoom_out')" @click="zoom(1 / 1.4)"><tw-icon name="minus"/></button>
        <button class="tw-tool" :aria-label="t('fit')" :title="t('fit')" @click="fit"><tw-icon name="fit"/></button>
        <button class="tw-tool" :aria-label="t('follow')" :title="t('follow')" :aria-pressed="follows" @click="toggleFollow"><tw-icon name="follow"/></button>
        <button class="tw-tool" :aria-label="t('save_picture')" :title="t('save_picture')" :aria-expanded="saves"
          @click="saves = !saves"><tw-icon name="save"/></button>
        <div v-if="saves" class="tw-save">
          <a class="tw-button small" :href="picture + '.svg'" :download="robot + '.svg'" @click="saves = false">SVG</a>
          <a class="tw-button small" :href="picture + '.png'" :download="robot + '.png'" @click="saves = false">PNG</a>
        </div>
      </div>
      <div class="tw-scale" :style="{width: scale.width + 'px'}">{{ scale.text }}</div>
    </section>
  `,
};

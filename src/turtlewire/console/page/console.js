// The page: its frame, its settings, and what belongs to all of its parts: driving, stopping, notices.

import { markRaw } from "vue";
import { Api } from "./api.js";
import Charts from "./charts.js";
import Drive from "./drive.js";
import Faults from "./faults.js";
import { Gamepads } from "./gamepad.js";
import { Grip } from "./grip.js";
import TwIcon from "./icons.js";
import { Keys } from "./keys.js";
import TwMap from "./map.js";
import Program from "./program.js";
import { PERIOD_MS, Samples } from "./samples.js";
import { loadSettings, saveSettings, THEMES } from "./settings.js";
import { LANGUAGES, translator } from "./texts.js";
import Traffic from "./traffic.js";
import Wheel from "./wheel.js";

const TABS = ["drive", "program", "traffic", "link"];
const ONE_BYTE = 1 / 255;
const ONE_STEP = 1 / 9;

// The page is not shown before it has its looks.
await Promise.all(
  ["console.css", "drive.css", "program.css", "traffic.css"].map(
    (name) =>
      new Promise((done) => {
        const link = Object.assign(document.createElement("link"), { rel: "stylesheet", href: new URL(name, import.meta.url).href });
        link.onload = link.onerror = done;
        document.head.append(link);
      }),
  ),
);

export default {
  components: { TwMap, TwWheel: Wheel, Drive, Program, Traffic, Faults, Charts },
  props: { base: { type: String, default: "" } },

  data() {
    return {
      api: markRaw(new Api(this.base)),
      robot: "",
      tab: "drive",
      visited: { drive: true },
      isMapHidden: false,
      settings: loadSettings(),
      held: { isHeld: false, ended: null },
      gamepad: null,
      isStopping: false,
      languages: LANGUAGES,
      themes: THEMES,
      tabs: TABS,
    };
  },

  computed: {
    t() {
      return translator(this.settings.language);
    },
    state() {
      return this.api.store.robots[this.robot];
    },
    robots() {
      return this.api.store.order.map((name) => this.api.store.robots[name].info);
    },
    sample() {
      return this.samplesOf(this.robot);
    },
    steering() {
      return [this.robot, this.state?.info, this.settings.speed, this.settings.turn];
    },
  },

  watch: {
    settings: {
      deep: true,
      handler(settings) {
        saveSettings(settings);
      },
    },
    "settings.language": { immediate: true, handler: "speak" },
    "settings.theme": { immediate: true, handler: "colour" },
    steering: { handler: "rig" },
    tab(tab) {
      this.visited[tab] = true;
    },
    "state.drives"(drives, before) {
      if (before && !drives) this.grip.letGo("wheel_taken");
    },
    "state.refused"(number) {
      if (number != null && number >= this.grip.grips) this.grip.letGo("stopped");
    },
    "state.view.link"(link) {
      if (link && link !== "connected") this.grip.letGo("not_reached");
    },
  },

  created() {
    const app = this.$.appContext.app;
    if (!app.component("TwIcon")) app.component("TwIcon", TwIcon);
    this.samples = new Map();
    this.noticed = new Map();
    const { api } = this;
    this.grip = markRaw(
      new Grip(api, () => {
        this.held = { isHeld: this.grip.isHeld, ended: this.grip.ended };
      }),
    );
    api.on("welcome", () => this.greet());
    api.on("robots", () => this.choose());
    api.on("state", ({ robot }) => this.notice(robot));
    api.on("lost", () => this.grip.letGo("connection"));
    api.on("stopping", () => this.grip.letGo("stopped"));
    api.on("refused", (refusal) => this.refused(refusal));
    api.on("notice", (notice) => api.say(notice.level, this.t.notice(notice)));
    const act = (name, value) => this.act(name, value);
    const stop = () => this.stop();
    this.keys = new Keys({
      grip: this.grip,
      stop,
      act,
      layout: () => this.settings.layout,
      isBusy: () => document.querySelector("dialog[open]") !== null,
    });
    this.gamepads = new Gamepads({
      grip: this.grip,
      stop,
      act,
      changed: (name) => {
        this.gamepad = name;
      },
    });
  },

  mounted() {
    this.keys.start();
    this.gamepads.start();
    this.outside = [
      [window, "blur", () => this.grip.letGo("blur")],
      [window, "pagehide", () => this.hide()],
      [document, "visibilitychange", () => (document.hidden ? this.hide() : this.show())],
    ];
    for (const [target, type, listener] of this.outside) target.addEventListener(type, listener);
    this.sampling = setInterval(() => this.takeSamples(), PERIOD_MS);
    this.api.open();
  },

  beforeUnmount() {
    this.keys.end();
    this.gamepads.end();
    for (const [target, type, listener] of this.outside) target.removeEventListener(type, listener);
    clearInterval(this.sampling);
    this.grip.letGo();
    this.api.close();
  },

  methods: {
    // -------------------------------------------------------------- which robot

    greet() {
      if (this.settings.name) this.api.send({ type: "name", name: this.settings.name });
      this.choose();
    },

    choose(name = this.robot) {
      const { order } = this.api.store;
      this.robot = order.includes(name) ? name : (order[0] ?? "");
      this.rig();
    },

    rig() {
      const { grip, settings, state } = this;
      grip.setRobot(this.robot || null);
      if (!state) return;
      grip.combines = state.info.combines ?? true;
      grip.steers = state.info.steers ?? false;
      grip.limits = { speed: settings.speed, turn: settings.turn };
    },

    rename() {
      this.api.send({ type: "name", name: this.settings.name });
    },

    // -------------------------------------------------------------- stop, and what is done once

    async stop(robot = this.robot || null) {
      this.isStopping = true;
      navigator.vibrate?.(60);
      const isSent = this.api.isOpen;
      const isDone = await this.api.stop(robot);
      if (!isDone && !isSent) this.api.say("error", this.t("stop_failed"));
      setTimeout(() => {
        this.isStopping = false;
      }, 600);
    },

    // A click that no pointer's press came before.
    stopByKey({ detail }, robot) {
      if (detail === 0) this.stop(robot);
    },

    async act(name, value) {
      const { settings, state } = this;
      const limit = (which, by) => {
        settings[which] = Math.min(1, Math.max(0.05, settings[which] + by));
      };
      const both = (by) => ["speed", "turn"].forEach((which) => limit(which, by));
      const has = (feature) => state?.info.features?.includes(feature);
      if (name === "speed") both(value - settings.speed);
      else if (name === "faster") both(ONE_STEP);
      else if (name === "slower") both(-ONE_STEP);
      else if (name === "speed_more") limit("speed", ONE_BYTE);
      else if (name === "speed_less") limit("speed", -ONE_BYTE);
      else if (name === "turn_more") limit("turn", ONE_BYTE);
      else if (name === "turn_less") limit("turn", -ONE_BYTE);
      else if (name === "ask_speed" || name === "ask_turn") this.askLimit(name === "ask_speed" ? "speed" : "turn");
      else if (name === "pen" && has("pen")) await this.command("pen", !state.view?.pen_down);
      else if (name === "pen_up" && has("pen")) await this.command("pen", false);
      else if (name === "pen_down" && has("pen")) await this.command("pen", true);
      else if (name === "lamp" && (has("lamp") || has("headlights"))) await this.command("lamp", !state.view?.lamp);
      else if (name === "resume") await this.command("resume");
      else if (name === "clean") await this.command("clean");
    },

    async command(name, value) {
      try {
        await this.api.takeFreeWheel(this.robot);
        await this.api.command(this.robot, name, value);
      } catch (error) {
        this.api.say("warning", this.t.code(error));
      }
    },

    async askLimit(which) {
      this.grip.letGo();
      this.tab = "drive";
      await this.$nextTick();
      this.$el.querySelector(`[data-limit=${which}]`)?.focus();
    },

    // -------------------------------------------------------------- what the server says

    refused({ what, robot, code, text }) {
      if (what === "drive") {
        // the refusal may be here before the state which says that the wheel is gone
        const why = code === "not_the_driver" && this.state?.drives ? "wheel_taken" : code;
        if (robot === this.robot) this.grip.letGo(this.t.has(`ended_${why}`) ? why : "refused");
      } else this.api.say("warning", this.t.code({ code, text }));
    },

    notice(name) {
      const notices = this.api.store.robots[name]?.view?.notices ?? [];
      const newest = notices.length ? notices[notices.length - 1].number : 0;
      const seen = this.noticed.get(name);
      this.noticed.set(name, newest);
      if (seen === undefined) return;
      for (const notice of notices) {
        if (notice.number <= seen) continue;
        if (notice.code === "limit" && notice.x_mm != null) {
          this.api.tell("limit", { robot: name, x: notice.x_mm, y: notice.y_mm });
          if (name === this.robot) this.grip.letGo("limit");
        }
        if (name === this.robot || notice.level === "error") this.api.say(notice.level, this.t.notice(notice));
      }
    },

    samplesOf(name) {
      if (!this.samples.has(name)) this.samples.set(name, new Samples());
      return this.samples.get(name);
    },

    takeSamples() {
      for (const name of this.api.store.order) {
        const { view } = this.api.store.robots[name];
        if (view) this.samplesOf(name).add(view.figures ?? {}, view.time_s);
      }
    },

    // -------------------------------------------------------------- the window

    hide() {
      this.grip.letGo("hidden");
      this.api.send({ type: "visible", visible: false });
    },

    show() {
      this.api.send({ type: "visible", visible: true });
    },

    speak(language) {
      document.documentElement.lang = language;
    },

    colour(theme) {
      Quasar.Dark.set(theme === "auto" ? "auto" : theme === "dark");
    },

    // What was clicked with a pointer does not keep the arrows for itself: they drive.
    unfocus(event) {
      if (event.detail === 0) return;
      event.target.closest("button, [role=tab], input[type=range]")?.blur();
    },

    tabKey(event) {
      const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      const at = event.key === "Home" ? 0 : event.key === "End" ? TABS.length - 1 : null;
      if (by === undefined && at === null) return;
      event.preventDefault();
      this.tab = TABS[at ?? (TABS.indexOf(this.tab) + by + TABS.length) % TABS.length];
      this.$nextTick(() => this.$el.querySelector(`#tw-tab-${this.tab}`).focus());
    },
  },

  template: `
    <div class="tw" :class="['tab-' + tab, {'map-hidden': isMapHidden}]" @click="unfocus">
      <a class="tw-skip" href="#tw-panel">{{ t('skip') }}</a>
      <header class="tw-head">
        <h1 class="tw-brand"><svg viewBox="0 0 32 32" aria-hidden="true"><path d="M16 4.5Q19 15 24.5 26 16 20 7.5 26 13 15 16 4.5z"/></svg>
          <span>turtlewire</span></h1>
        <label v-if="robots.length > 1" class="tw-robot"><span class="tw-hidden">{{ t('robot') }}</span>
          <select class="tw-field" :value="robot" @change="choose($event.target.value)">
            <option v-for="info in robots" :key="info.name" :value="info.name">{{ info.name }}</option>
          </select></label>
        <span v-else class="tw-robot-name">{{ state?.info.title }}</span>
        <span class="tw-connection" :class="api.store.connection" role="status"><i></i><span>{{
          t(api.store.connection === 'open' ? 'connected' : api.store.connection) }}</span></span>
        <button class="tw-tool plain" :aria-label="t('settings')" :title="t('settings')" @click="$refs.dialog.showModal()">
          <tw-icon name="gear"/></button>
      </header>

      <div class="tw-stage">
        <template v-if="state">
          <tw-map :api="api" :robot="robot" :theme="settings.theme" :t="t"></tw-map>
          <div class="tw-side">
            <div>
              <p v-if="state.faults?.on" class="tw-banner" role="status"><tw-icon name="warning"/>{{ t('faults_banner') }}</p>
              <tw-wheel :api="api" :robot="robot" :state="state" :t="t"></tw-wheel>
            </div>
            <div class="tw-tabs" role="tablist" :aria-label="t('panels')" @keydown="tabKey">
              <button v-for="name in tabs" :key="name" :id="'tw-tab-' + name" class="tw-tab" role="tab"
                :aria-selected="tab === name" aria-controls="tw-panel" :tabindex="tab === name ? 0 : -1" @click="tab = name">
                <tw-icon :name="name"/><span>{{ t(name) }}</span></button>
            </div>
            <div class="tw-panel" id="tw-panel" role="tabpanel" :aria-labelledby="'tw-tab-' + tab" tabindex="-1">
              <drive v-show="tab === 'drive'" :api="api" :robot="robot" :state="state" :t="t" :grip="grip" :held="held"
                :settings="settings" :gamepad="gamepad" @act="act"></drive>
              <program v-if="visited.program" v-show="tab === 'program'" :api="api" :robot="robot" :state="state" :t="t"></program>
              <traffic v-if="visited.traffic" v-show="tab === 'traffic'" :api="api" :robot="robot" :state="state" :t="t"></traffic>
              <div v-if="visited.link" v-show="tab === 'link'">
                <charts :key="robot" :state="state" :samples="sample" :is-shown="tab === 'link'" :theme="settings.theme" :t="t"
                  :language="settings.language"></charts>
                <faults :api="api" :robot="robot" :state="state" :t="t"></faults>
              </div>
            </div>
          </div>
        </template>
        <p v-else class="tw-wait" role="status">{{ t(api.store.connection === 'lost' ? 'lost' : 'loading') }}</p>
      </div>

      <section class="tw-stops" :aria-label="t('stop')">
        <button class="tw-stop" :class="{pressed: isStopping}" :title="t('stop_help')" aria-keyshortcuts="Escape Space"
          @pointerdown="stop()" @click="stopByKey($event)">{{ t('stop') }}</button>
        <button v-if="robots.length > 1" class="tw-stop-all" @pointerdown="stop(null)" @click="stopByKey($event, null)">{{ t('stop_all') }}</button>
      </section>

      <section class="tw-toasts" :aria-label="t('messages')" aria-live="polite">
        <div v-for="toast in api.store.toasts" :key="toast.id" class="tw-toast" :class="toast.level"
          :role="toast.level === 'error' ? 'alert' : null">
          <tw-icon :name="toast.level"/><p>{{ toast.text }}<span v-if="toast.times > 1" class="tw-muted"> ×{{ toast.times }}</span></p>
          <button class="tw-tool plain" :aria-label="t('close_notice')" @click="api.forget(toast.id)"><tw-icon name="close"/></button>
        </div>
      </section>

      <dialog ref="dialog" class="tw-dialog" aria-labelledby="tw-settings">
        <h2 id="tw-settings">{{ t('settings') }}</h2>
        <label class="tw-pick"><span>{{ t('your_name') }}</span>
          <input class="tw-field" type="text" maxlength="30" autocomplete="nickname" v-model.trim="settings.name" @change="rename">
          <small class="tw-muted">{{ t('your_name_help') }}</small></label>
        <label class="tw-pick"><span>{{ t('language') }}</span>
          <select class="tw-field" name="language" v-model="settings.language">
            <option v-for="(title, name) in languages" :key="name" :value="name" :lang="name">{{ title }}</option></select></label>
        <label class="tw-pick"><span>{{ t('theme') }}</span>
          <select class="tw-field" name="theme" v-model="settings.theme">
            <option v-for="name in themes" :key="name" :value="name">{{ t('theme_' + name) }}</option></select></label>
        <div class="tw-row end"><button class="tw-button primary" @click="$refs.dialog.close()">{{ t('close') }}</button></div>
      </dialog>
    </div>
  `,
};

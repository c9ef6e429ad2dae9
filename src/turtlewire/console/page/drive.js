// Driving: the joystick or buttons, speeds, and what the robot has besides wheels.

import { LAYOUTS } from "./keys.js";
import Joystick from "./joystick.js";
import Status from "./status.js";

const PAD = [
  ["up", { speed: 1 }, "ahead"],
  ["left", { turn: -1 }, "left"],
  ["right", { turn: 1 }, "right"],
  ["down", { speed: -1 }, "back"],
];

export default {
  components: { Joystick, TwStatus: Status },
  props: { api: Object, robot: String, state: Object, t: Function, grip: Object, held: Object, settings: Object, gamepad: String },
  data: () => ({ pad: PAD, layouts: Object.keys(LAYOUTS) }),

  computed: {
    features() {
      return this.state.info.features ?? [];
    },
    link() {
      return this.state.view?.link ?? "connecting";
    },
    hasPen() {
      return this.features.includes("pen");
    },
    lights() {
      return this.features.includes("headlights") ? "headlights" : this.features.includes("lamp") ? "lamp" : null;
    },
    percent() {
      return (value) => `${Math.round(value * 100)} %`;
    },
    says() {
      if (this.link !== "connected") return this.t(`link_${this.link}`);
      if (this.held.ended) return this.t(`ended_${this.held.ended}`);
      if (this.held.isHeld) return this.t("held");
      return this.t("hold_to_drive");
    },
    keysHelp() {
      return this.t(`keys_${this.settings.layout}`);
    },
  },

  methods: {
    hold(source, what, event) {
      event.currentTarget.setPointerCapture?.(event.pointerId);
      this.grip.press(source, what);
    },
    release(source) {
      this.grip.release(source);
    },
    act(name) {
      this.$emit("act", name);
    },
  },

  emits: ["act"],

  template: `
    <div class="tw-drive">
      <div v-if="link !== 'connected'" class="tw-banner" :class="link === 'stopped' ? 'warning' : 'error'" role="alert">
        <tw-icon name="warning"/><span>{{ t('link_' + link) }}</span>
        <button v-if="link === 'stopped'" class="tw-button small primary" @click="act('resume')">{{ t('resume') }}</button>
      </div>
      <div class="tw-cockpit">
        <div class="tw-hand">
          <joystick v-if="settings.hand === 'stick'" :grip="grip" :is-held="held.isHeld" :t="t"></joystick>
          <div v-else class="tw-pad" role="group" :aria-label="t('pad')">
            <button v-for="[icon, what, name] in pad" :key="name" class="tw-pad-button" :class="icon"
              :aria-label="t('pad_' + name)" @contextmenu.prevent @pointerdown="hold('pad ' + name, what, $event)"
              @pointerup="release('pad ' + name)" @pointercancel="release('pad ' + name)"
              @lostpointercapture="release('pad ' + name)"><tw-icon :name="icon"/></button>
          </div>
          <p class="tw-hand-says" :class="{ended: held.ended, held: held.isHeld}" role="status">{{ says }}</p>
        </div>
        <div class="tw-equipment" role="group" :aria-label="t('equipment')">
          <button v-if="hasPen" class="tw-big" :aria-pressed="!!state.view?.pen_down" @click="act('pen')">
            <tw-icon name="pen"/><span>{{ t('pen') }}</span></button>
          <button v-if="lights" class="tw-big" :aria-pressed="!!state.view?.lamp" @click="act('lamp')">
            <tw-icon name="lamp"/><span>{{ t(lights) }}</span></button>
          <button v-if="features.includes('horn')" class="tw-big" :class="{on: state.view?.horn}" @contextmenu.prevent
            @pointerdown="hold('horn button', {horn: true}, $event)" @pointerup="release('horn button')"
            @pointercancel="release('horn button')" @lostpointercapture="release('horn button')">
            <tw-icon name="horn"/><span>{{ t('horn') }}</span></button>
          <button class="tw-big" @click="act('clean')"><tw-icon name="clean"/><span>{{ t('clean') }}</span></button>
        </div>
      </div>
      <div class="tw-limits">
        <label class="tw-slider"><span>{{ t('speed_limit') }}</span>
          <input type="range" min="5" max="100" step="1" data-limit="speed" :value="Math.round(settings.speed * 100)"
            :aria-valuetext="percent(settings.speed)" @input="settings.speed = $event.target.value / 100">
          <output>{{ percent(settings.speed) }}</output></label>
        <label v-if="!state.info.steers" class="tw-slider"><span>{{ t('turn_limit') }}</span>
          <input type="range" min="5" max="100" step="1" data-limit="turn" :value="Math.round(settings.turn * 100)"
            :aria-valuetext="percent(settings.turn)" @input="settings.turn = $event.target.value / 100">
          <output>{{ percent(settings.turn) }}</output></label>
      </div>
      <tw-status :state="state" :t="t" :language="settings.language"></tw-status>
      <section class="tw-keys" :aria-label="t('controls')">
        <div class="tw-row">
          <label class="tw-pick"><span>{{ t('hand') }}</span>
            <select class="tw-field" v-model="settings.hand">
              <option value="stick">{{ t('hand_stick') }}</option><option value="pad">{{ t('hand_pad') }}</option>
            </select></label>
          <label class="tw-pick"><span>{{ t('keyboard') }}</span>
            <select class="tw-field" v-model="settings.layout">
              <option v-for="name in layouts" :key="name" :value="name">{{ t('layout_' + name) }}</option>
            </select></label>
        </div>
        <p class="tw-muted">{{ keysHelp }}</p>
        <p class="tw-muted">{{ gamepad ? t('gamepad_is', {name: gamepad}) : t('gamepad_none') }}</p>
      </section>
    </div>
  `,
};

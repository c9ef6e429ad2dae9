// What goes wrong on the way to a simulated robot, on purpose: turned up and down while it drives.

const RATES = [0, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5];
const DELAYS = [0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2];
const PIECES = [0, 16, 8, 4, 2, 1];
const SLIDERS = [
  ["lose", RATES],
  ["add", RATES],
  ["flip", RATES],
  ["duplicate", RATES],
  ["delay_s", DELAYS],
  ["split", PIECES],
];
const NONE = { lose: 0, add: 0, flip: 0, duplicate: 0, delay_s: 0, split: 0, to: "" };
const SEND_MS = 150;
// What was moved here is not moved back by what the server said before it heard of it.
const SETTLED_MS = 600;

const nearest = (steps, value) =>
  steps.reduce((best, step, at) => (Math.abs(step - value) < Math.abs(steps[best] - value) ? at : best), 0);

export default {
  props: { api: Object, robot: String, state: Object, t: Function },
  data: () => ({ wanted: { ...NONE }, movedAt: -Infinity, stall_s: 2, unplug_s: 5, sliders: SLIDERS }),

  computed: {
    faults() {
      return this.state.faults;
    },
    address() {
      return `/api/robots/${encodeURIComponent(this.robot)}/faults`;
    },
    done() {
      const { faults, t } = this;
      if (!faults) return [];
      return ["lost", "added", "flipped", "duplicated"].map((name) => [name, t(`faults_${name}`), faults[name]]);
    },
    isRough() {
      return Object.keys(NONE).some((name) => this.wanted[name] !== NONE[name] && name !== "to");
    },
  },

  watch: {
    faults: { immediate: true, handler: "follow" },
    robot() {
      this.movedAt = -Infinity;
      this.follow();
    },
  },

  beforeUnmount() {
    clearTimeout(this.sending);
  },

  methods: {
    follow() {
      const { faults } = this;
      if (!faults || performance.now() - this.movedAt < SETTLED_MS) return;
      for (const name of Object.keys(NONE)) this.wanted[name] = faults[name];
    },

    step(name, steps) {
      return nearest(steps, this.wanted[name]);
    },

    move(name, value) {
      this.wanted[name] = value;
      this.movedAt = performance.now();
      this.sending ??= setTimeout(() => this.send(), SEND_MS);
    },

    async send() {
      clearTimeout(this.sending);
      this.sending = null;
      await this.ask("PUT", "", { ...this.wanted });
    },

    off() {
      Object.assign(this.wanted, NONE);
      this.movedAt = performance.now();
      this.send();
    },

    async ask(method, path, body) {
      try {
        await this.api.takeFreeWheel(this.robot);
        this.state.faults = await this.api.request(method, this.address + path, body);
      } catch (error) {
        this.movedAt = -Infinity;
        this.follow();
        this.api.say("warning", this.t.code(error));
      }
    },

    says(name, value) {
      const { t } = this;
      const number = (what) => what.toLocaleString(t.language, { maximumFractionDigits: 3 });
      if (!value) return t(name === "split" ? "faults_whole" : "faults_none");
      if (name === "delay_s") return value < 1 ? `${number(value * 1000)} ms` : `${number(value)} s`;
      if (name === "split") return t("faults_bytes", { count: value });
      return `${number(value * 100)} %`;
    },
  },

  template: `
    <section v-if="faults" class="tw-card tw-faults" :class="{on: faults.on}" :aria-label="t('faults_title')">
      <div class="tw-row tw-faults-head"><h2>{{ t('faults_title') }}</h2>
        <span class="tw-chip" :class="faults.on ? 'danger' : ''">{{ t(faults.on ? 'faults_on' : 'faults_off') }}</span>
        <button class="tw-button small" name="faults-off" :disabled="!isRough" @click="off">{{ t('faults_all_off') }}</button></div>
      <p class="tw-muted">{{ t('faults_help') }}</p>
      <div class="tw-faults-sliders">
        <label v-for="[name, steps] in sliders" :key="name" class="tw-slide"><span>{{ t('faults_' + name) }}</span>
          <input type="range" min="0" :max="steps.length - 1" step="1" :name="name" :value="step(name, steps)"
            :aria-valuetext="says(name, wanted[name])" @input="move(name, steps[$event.target.valueAsNumber])">
          <output>{{ says(name, wanted[name]) }}</output></label>
        <label class="tw-slide"><span>{{ t('faults_to') }}</span>
          <select class="tw-field" name="to" :value="wanted.to" @change="move('to', $event.target.value)">
            <option value="">{{ t('traffic_both') }}</option>
            <option value="robot">{{ t('traffic_to_robot') }}</option>
            <option value="host">{{ t('traffic_to_host') }}</option></select></label>
      </div>
      <div class="tw-row">
        <button class="tw-button small" name="stall" :disabled="faults.stalled_s > 0" @click="ask('POST', '/stall', {seconds: stall_s})">{{
          faults.stalled_s > 0 ? t('faults_stalled', {seconds: faults.stalled_s}) : t('faults_stall', {seconds: stall_s}) }}</button>
        <button class="tw-button small" name="unplug" :disabled="faults.unplugged_s > 0" @click="ask('POST', '/unplug', {seconds: unplug_s})">{{
          faults.unplugged_s > 0 ? t('faults_unplugged', {seconds: faults.unplugged_s}) : t('faults_unplug', {seconds: unplug_s}) }}</button>
      </div>
      <dl class="tw-figures tw-faults-done"><div v-for="[name, title, count] in done" :key="name"><dt>{{ title }}</dt><dd>{{ count }}</dd></div></dl>
    </section>
  `,
};

// Who drives: take the wheel, ask for it, hand it over, let it go; and how many look on.

export default {
  props: { api: Object, robot: String, state: Object, t: Function },
  data: () => ({ askedAt: 0, now: 0 }),

  computed: {
    wheel() {
      return this.state.wheel ?? { driver: null, asker: null, asking: [], watchers: 0 };
    },
    isFree() {
      return this.wheel.driver == null;
    },
    asks() {
      return this.wheel.asking.includes(this.api.store.id);
    },
    isAsked() {
      return this.state.drives && this.wheel.asker != null;
    },
    seconds() {
      return Math.max(0, Math.ceil((this.wheel.asked_for_s ?? 0) - (this.now - this.askedAt) / 1000));
    },
    says() {
      if (this.state.drives) return this.t("you_drive");
      return this.isFree ? this.t("nobody_drives") : this.t("drives", { name: this.driver });
    },
    driver() {
      return this.wheel.driver_name || this.t("somebody");
    },
    asker() {
      return this.wheel.asker_name || this.t("somebody");
    },
  },

  watch: {
    "wheel.asked_for_s"() {
      this.askedAt = this.now = performance.now();
    },
    isAsked(is) {
      if (is) navigator.vibrate?.(80);
    },
  },

  mounted() {
    this.timer = setInterval(() => {
      if (this.wheel.asker != null) this.now = performance.now();
    }, 250);
  },

  beforeUnmount() {
    clearInterval(this.timer);
  },

  methods: {
    turn(action, to) {
      this.api.wheel(this.robot, action, to);
    },
  },

  template: `
    <section class="tw-wheel" :class="{mine: state.drives, free: isFree}" :aria-label="t('wheel')">
      <span class="tw-wheel-icon"><tw-icon name="drive"/></span>
      <strong class="tw-wheel-says" role="status">{{ says }}</strong>
      <span class="tw-chip" :title="t('watchers', {count: wheel.watchers})">
        <tw-icon name="eye"/><span aria-hidden="true">{{ wheel.watchers }}</span>
        <span class="tw-hidden">{{ t('watchers', {count: wheel.watchers}) }}</span>
      </span>
      <button v-if="isFree" class="tw-button small primary" @click="turn('take')">{{ t('take_wheel') }}</button>
      <button v-else-if="state.drives" class="tw-button small" @click="turn('release')">{{ t('release_wheel') }}</button>
      <button v-else class="tw-button small" :disabled="asks" @click="turn('ask')">
        {{ asks ? t('asked', {seconds}) : t('ask_wheel') }}
      </button>
      <div v-if="isAsked" class="tw-ask tw-card" role="alertdialog" aria-labelledby="tw-ask-says">
        <p id="tw-ask-says">{{ t('asks', {name: asker}) }}<span class="tw-muted"> {{ t('asks_seconds', {seconds}) }}</span></p>
        <div class="tw-row">
          <button class="tw-button primary" @click="turn('give', wheel.asker)">{{ t('give_wheel') }}</button>
          <button class="tw-button" @click="turn('keep')">{{ t('keep_wheel') }}</button>
        </div>
      </div>
    </section>
  `,
};

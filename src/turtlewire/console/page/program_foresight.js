// What a program would do, before the robot starts: its figures, and its lines on the map.

const WHY = { "uses chance": "program_chance", "asks the limit sensors": "program_sensors", "reads the keyboard": "program_keyboard" };

export function duration(seconds) {
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

export default {
  props: { api: Object, t: Function, robot: String, text: String, file: String },
  emits: ["place"],
  data: () => ({ found: null, isLooking: false }),

  computed: {
    rows() {
      const { found, t } = this;
      const more = (value) => (found.is_whole ? value : t("program_more_than", { value }));
      const size = ({ left_mm, right_mm, bottom_mm, top_mm }) =>
        t("program_size", { width: Math.round(right_mm - left_mm), height: Math.round(top_mm - bottom_mm) });
      const metres = (mm) => (mm / 1000).toFixed(2);
      const rows = [
        ["drawing", found.drawing ? size(found.drawing) : t("program_draws_nothing")],
        ["way", size(found.way)],
        ["path", more(t("program_path_says", { path: metres(found.path_mm), pen: metres(found.pen_down_mm) }))],
        ["takes", more(duration(found.seconds))],
      ];
      if (found.stays_in_arena !== null) rows.push(["arena", this.arena(found.touch)]);
      return rows;
    },
    why() {
      return this.found.asks.map((reason) => this.t(WHY[reason] ?? "program_chance")).join(", ");
    },
  },

  watch: {
    text: "forget",
    robot(robot, before) {
      this.api.overlay(before, null);
      this.found = null;
    },
  },

  beforeUnmount() {
    this.forget();
  },

  methods: {
    arena(touch) {
      if (!touch) return this.t("program_clear_of");
      const values = { x: Math.round(touch.x_mm), y: Math.round(touch.y_mm), line: touch.line };
      return this.t(touch.line ? "program_touches_line" : "program_touches", values);
    },

    async look() {
      if (this.isLooking) return;
      this.forget();
      this.isLooking = true;
      const { robot, text } = this;
      try {
        const found = await this.api.request("POST", `/api/robots/${encodeURIComponent(robot)}/preview`, { source: text, name: this.file });
        if (robot !== this.robot || text !== this.text) return;
        this.found = found;
        this.api.overlay(robot, found.strokes);
        await this.$nextTick();
        this.$refs.card?.scrollIntoView({ block: "nearest" });
      } catch (error) {
        this.api.say("warning", this.t.code(error));
      } finally {
        this.isLooking = false;
      }
    },

    forget() {
      this.found = null;
      this.api.overlay(this.robot, null);
    },
  },

  template: `
    <p v-if="isLooking" class="tw-muted" role="status">{{ t('program_looking') }} …</p>
    <section v-if="found" ref="card" class="tw-card tw-foresight" :aria-label="t('program_would')" data-part="preview">
      <header class="tw-row"><h2>{{ t('program_would') }}</h2>
        <button class="tw-tool plain" :aria-label="t('close')" @click="forget"><tw-icon name="close"/></button></header>
      <dl><template v-for="[name, value] in rows" :key="name"><dt>{{ t('program_' + name) }}</dt><dd :data-row="name">{{ value }}</dd></template></dl>
      <p v-if="!found.is_whole" class="tw-warn">{{ t('program_endless') }}</p>
      <p v-if="found.asks.length" class="tw-muted">{{ t('program_estimate', {why}) }}</p>
      <p v-if="found.error" class="tw-warn">{{ t('program_ends_with') }}:
        <button v-if="found.error.line" class="tw-place" @click="$emit('place', found.error)">{{ t('program_line', {line: found.error.line}) }}</button>
        {{ found.error.text }}</p>
    </section>
  `,
};

// How the robot is: where, how fast, its equipment, its limit sensors, and what it had to say.

const MAX_NOTICES = 5;
const AT_LIMIT_MM = 5;

export default {
  props: { state: Object, t: Function, language: String },

  computed: {
    view() {
      return this.state.view;
    },
    rows() {
      const { view, t } = this;
      if (!view) return [];
      const number = (value, unit, digits = 0) => {
        const rounded = Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value;
        return `${rounded.toLocaleString(this.language, { maximumFractionDigits: digits, minimumFractionDigits: digits })}${unit}`;
      };
      const { pose } = view;
      return [
        ["x", number(pose.x_mm, " mm", 1)],
        ["y", number(pose.y_mm, " mm", 1)],
        [t("heading"), number(((pose.heading_deg % 360) + 360) % 360, "°", 1)],
        [t("speed"), number(view.speed_mm_per_s, " mm/s")],
        [t("turning"), number(view.turn_deg_per_s, "°/s")],
        [t("distance"), number(view.distance_mm / 1000, " m", 2)],
      ];
    },
    equipment() {
      const { view, t } = this;
      if (!view) return [];
      const chips = [];
      if (view.pen_down != null) chips.push(["pen", view.pen_down, t(view.pen_down ? "pen_is_down" : "pen_is_up")]);
      if (view.lamp != null) chips.push(["lamp", view.lamp, t(view.lamp ? "lamp_is_on" : "lamp_is_off")]);
      const limit = this.limit;
      if (limit) chips.push(["warning", true, t("limit_hit", { sensor: t(`sensor_${limit.sensor}`) }), "danger"]);
      else if (this.state.info.features.includes("limits")) chips.push(["good", false, t("limits_clear")]);
      return chips;
    },
    // Robots tell that a sensor has stopped them, not that it is free again: it is when they are somewhere else.
    limit() {
      const { notices, pose } = this.view;
      const limit = notices.findLast((notice) => notice.code === "limit" && notice.x_mm != null);
      return limit && Math.hypot(limit.x_mm - pose.x_mm, limit.y_mm - pose.y_mm) < AT_LIMIT_MM ? limit : null;
    },
    certainty() {
      return this.view ? this.t(`certainty_${this.view.certainty}`) : "";
    },
    notices() {
      return (this.view?.notices ?? []).slice(-MAX_NOTICES).reverse();
    },
  },

  template: `
    <section class="tw-status" :aria-label="t('status')">
      <dl class="tw-figures">
        <div v-for="[name, value] in rows" :key="name"><dt>{{ name }}</dt><dd>{{ value }}</dd></div>
      </dl>
      <ul class="tw-chips" v-if="equipment.length || certainty">
        <li v-for="[icon, on, says, level] in equipment" :key="says" class="tw-chip" :class="[{on}, on ? level : '']">
          <tw-icon :name="icon"/>{{ says }}</li>
        <li v-if="certainty" class="tw-chip">{{ certainty }}</li>
      </ul>
      <section v-if="notices.length" class="tw-notices" :aria-label="t('notices')">
        <h2>{{ t('notices') }}</h2>
        <ol>
          <li v-for="notice in notices" :key="notice.number" :class="notice.level">
            <tw-icon :name="notice.level"/><span class="tw-mono tw-muted">{{ notice.time_s.toFixed(1) }} s</span>
            <span>{{ t.notice(notice) }}</span>
          </li>
        </ol>
      </section>
    </section>
  `,
};

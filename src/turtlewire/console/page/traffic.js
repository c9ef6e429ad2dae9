// What passes on the robot's wire, both directions, decoded; and a line to write messages in.
//
// The list shows only the rows that are seen: whatever the line carries, the page stays quick.

import { markRaw } from "vue";
import { copy, Lines } from "./lines.js";
import Message from "./message.js";

const ROW = 44;
// Rows beyond what is seen, at both ends.
const MORE = 8;
// How often what has come is drawn.
const DRAW_MS = 120;
const HISTORY = 1000;

export default {
  components: { TwMessage: Message },
  props: { api: Object, robot: String, state: Object, t: Function },

  data: () => ({
    filter: { sender: "", kind: "", name: "", text: "" },
    names: [],
    isPaused: false,
    waiting: 0,
    total: 0,
    count: 0,
    first: 0,
    rows: [],
    chosen: null,
    copied: "",
    row: ROW,
  }),

  computed: {
    saveAddress() {
      return `${this.api.base}/api/robots/${encodeURIComponent(this.robot)}/traffic/recording`;
    },
    counted() {
      const { count, total, t } = this;
      return count === total ? t("traffic_count", { count }) : t("traffic_count_of", { count, total });
    },
  },

  watch: {
    filter: {
      deep: true,
      handler(filter) {
        this.lines.filter = { ...filter, text: filter.text.trim() };
        this.lines.refilter();
        this.draw(true);
      },
    },
    robot: "begin",
  },

  created() {
    this.lines = markRaw(new Lines());
    this.following = true;
    this.isSeen = false;
    this.fetches = 0;
    this.off = [
      this.api.on("traffic", (message) => this.hear(message)),
      this.api.on("welcome", () => this.begin()),
    ];
  },

  mounted() {
    this.seeing = new IntersectionObserver(([entry]) => this.see(entry.isIntersecting));
    this.seeing.observe(this.$el);
    this.sizing = new ResizeObserver(() => this.draw());
    this.sizing.observe(this.$refs.list);
  },

  beforeUnmount() {
    for (const off of this.off) off();
    this.seeing.disconnect();
    this.sizing.disconnect();
    clearTimeout(this.drawing);
    if (this.isSeen) this.api.send({ type: "traffic", on: false });
  },

  methods: {
    // -------------------------------------------------------------- what comes

    see(isSeen) {
      if (isSeen === this.isSeen) return;
      this.isSeen = isSeen;
      if (isSeen) this.listen();
      else this.api.send({ type: "traffic", on: false });
    },

    begin() {
      this.lines.reset();
      this.lines.filter = { ...this.filter };
      this.isPaused = false;
      this.chosen = null;
      this.following = true;
      this.draw(true);
      if (this.isSeen) this.listen();
    },

    // Have everything from now on told, and see what was before.
    async listen() {
      const number = ++this.fetches;
      this.api.send({ type: "traffic", on: true });
      this.early = [];
      let lines = [];
      let lost = 0;
      try {
        const since = this.lines.last + 1;
        const address = `/api/robots/${encodeURIComponent(this.robot)}/traffic`;
        ({ lines, lost } = await this.api.request("GET", `${address}?since=${since}&limit=${HISTORY}&newest=true`));
      } catch {
        // the stream goes on without
      }
      if (number !== this.fetches) return;
      this.lines.add(lines, lost);
      for (const message of this.early) this.lines.add(message.lines, message.lost);
      this.early = null;
      this.drawSoon();
    },

    hear(message) {
      if (message.robot !== this.robot || !this.isSeen) return;
      if (this.early) this.early.push(message);
      else {
        this.lines.add(message.lines, message.lost);
        this.drawSoon();
      }
    },

    // -------------------------------------------------------------- what is seen

    drawSoon() {
      this.drawing ??= setTimeout(() => this.draw(), DRAW_MS);
    },

    draw(isNew = false) {
      clearTimeout(this.drawing);
      this.drawing = null;
      const { lines } = this;
      const list = this.$refs.list;
      if (!list) return;
      if (isNew) this.droppedBefore = 0;
      const gone = lines.dropped - (this.droppedBefore ?? 0);
      this.droppedBefore = lines.dropped;
      this.waiting = lines.waiting;
      this.total = lines.all.length;
      this.count = lines.shown.length;
      if (lines.names.size !== this.names.length) this.names = [...lines.names].sort();
      const end = Math.max(0, this.count * ROW - list.clientHeight);
      let top = this.following && !lines.isPaused ? end : Math.max(0, list.scrollTop - gone * ROW);
      top = Math.min(top, end);
      this.window(top);
      if (top !== list.scrollTop) {
        this.$nextTick(() => {
          this.moved = top;
          list.scrollTop = top;
        });
      }
    },

    window(top) {
      const seen = Math.ceil((this.$refs.list.clientHeight || 0) / ROW);
      this.first = Math.max(0, Math.floor(top / ROW) - MORE);
      this.rows = markRaw(this.lines.shown.slice(this.first, this.first + seen + 2 * MORE));
    },

    scrolled() {
      const list = this.$refs.list;
      if (this.moved !== undefined && Math.abs(list.scrollTop - this.moved) < 1) this.moved = undefined;
      else this.following = list.scrollTop + list.clientHeight >= list.scrollHeight - ROW / 2;
      this.window(list.scrollTop);
    },

    toEnd() {
      this.following = true;
      this.draw();
    },

    // -------------------------------------------------------------- what is done

    pause() {
      const { lines } = this;
      if (lines.isPaused) lines.goOn();
      else lines.pause();
      this.isPaused = lines.isPaused;
      this.draw();
    },

    clear() {
      this.lines.clear();
      this.chosen = null;
      this.names = [];
      this.filter.name = "";
      this.draw(true);
    },

    copyAll() {
      this.say(copy(this.lines.asText()), this.count);
    },

    copyChosen() {
      this.say(copy(this.lines.asText([this.chosen])), 1);
    },

    say(isDone, count) {
      this.api.say(isDone ? "good" : "error", this.t(isDone ? "traffic_copied" : "traffic_not_copied", { count }));
    },

    choose(line) {
      this.chosen = this.chosen?.number === line.number ? null : line;
    },

    says(line) {
      const { t } = this;
      if (line.kind === "gap") return t("traffic_gap", { count: line.lost });
      if (line.kind === "error") return t("traffic_error", { text: line.text });
      if (line.kind === "skipped") return t("traffic_skipped", { text: line.text });
      return line.text;
    },

    from(line) {
      return line.from === "host" ? this.t("traffic_host") : line.from === "robot" ? this.t("traffic_robot") : "";
    },
  },

  template: `
    <section class="tw-traffic" :aria-label="t('traffic')">
      <tw-message :api="api" :robot="robot" :state="state" :t="t"></tw-message>

      <div class="tw-traffic-tools">
        <div class="tw-row">
          <button class="tw-button small" name="pause" :aria-pressed="isPaused" @click="pause">{{ t(isPaused ? 'traffic_go_on' : 'traffic_pause') }}</button>
          <button class="tw-button small" name="clear" @click="clear">{{ t('traffic_clear') }}</button>
          <button class="tw-button small" name="copy" :disabled="!count" @click="copyAll">{{ t('traffic_copy') }}</button>
          <a class="tw-button small" :href="saveAddress" :title="t('traffic_save_help')" download>
            <tw-icon name="save"/>{{ t('traffic_save') }}</a>
        </div>
        <details class="tw-filter">
          <summary>{{ t('traffic_filter') }}<span class="tw-muted tw-traffic-count" role="status">{{ counted }}<template v-if="waiting"> · <strong>{{
            t('traffic_new', { count: waiting }) }}</strong></template></span></summary>
          <div class="tw-row">
            <select class="tw-field" name="sender" :aria-label="t('traffic_direction')" v-model="filter.sender">
              <option value="">{{ t('traffic_both') }}</option>
              <option value="host">{{ t('traffic_to_robot') }}</option>
              <option value="robot">{{ t('traffic_to_host') }}</option>
            </select>
            <select class="tw-field" name="name" :aria-label="t('traffic_kind')" v-model="filter.name">
              <option value="">{{ t('traffic_all') }}</option>
              <option v-for="name in names" :key="name" :value="name">{{ name }}</option>
            </select>
          </div>
          <div class="tw-row">
            <input class="tw-field" type="search" name="search" :aria-label="t('traffic_search')" :placeholder="t('traffic_search')"
              autocomplete="off" spellcheck="false" v-model="filter.text">
            <label class="tw-check"><input type="checkbox" name="errors" true-value="error" false-value="" v-model="filter.kind">
              {{ t('traffic_errors') }}</label>
          </div>
        </details>
      </div>

      <div class="tw-lines" ref="list" tabindex="0" role="region" data-own-arrows :aria-label="t('traffic_lines')" @scroll.passive="scrolled">
        <div v-if="count" class="tw-lines-all" role="list" :style="{height: count * row + 'px'}">
          <div v-for="(line, at) in rows" :key="line.number" class="tw-line" role="listitem" :aria-setsize="count"
            :aria-posinset="first + at + 1" :class="[line.kind, line.from, {chosen: chosen && chosen.number === line.number}]"
            :style="{transform: 'translateY(' + (first + at) * row + 'px)'}" :data-number="line.number" @click="choose(line)">
            <span class="tw-line-from" :title="from(line)"><tw-icon v-if="line.kind === 'error'" name="error"/><tw-icon
              v-else-if="line.from" :name="line.from === 'host' ? 'right' : 'left'"/><tw-icon v-else name="note"/></span>
            <span class="tw-line-text tw-mono"><span class="tw-hidden">{{ from(line) }} </span>{{ says(line) }}</span>
            <span class="tw-line-time tw-mono tw-muted">{{ line.time_s.toFixed(3) }}</span>
            <span class="tw-line-raw tw-mono tw-muted">{{ line.raw }}</span>
            <span v-if="line.from" class="tw-line-at tw-mono tw-muted">@{{ line.offset }}</span>
          </div>
        </div>
        <p v-if="!count" class="tw-muted tw-lines-none">{{ t(total ? 'traffic_none_fits' : 'traffic_none') }}</p>
      </div>

      <div v-if="chosen" class="tw-card tw-line-whole">
        <p class="tw-mono">{{ says(chosen) }}</p>
        <p v-if="chosen.raw" class="tw-mono tw-bytes">{{ chosen.raw }}</p>
        <p class="tw-muted">{{ t('traffic_where', { from: from(chosen), time: chosen.time_s.toFixed(6), offset: chosen.offset,
          count: chosen.raw ? chosen.raw.split(' ').length : 0 }) }}</p>
        <div class="tw-row end">
          <button class="tw-button small" name="copy-line" @click="copyChosen">{{ t('traffic_copy_line') }}</button>
          <button class="tw-button small" @click="chosen = null">{{ t('close') }}</button>
        </div>
      </div>
    </section>
  `,
};

// How the link does: round trip, what was mended, bytes a second, over the last minutes, drawn and as a table.

import { recoveries } from "./samples.js";

const LOOK_MS = 1000;
// Every so many seconds one line of the table.
const TABLE_S = 15;
const TABLE_ROWS = 12;

const FIGURES = [
  "bytes_sent",
  "bytes_received",
  "round_trip_median_s",
  "round_trip_max_s",
  "retries",
  "resynchronisations",
  "fences_lost",
  "corrections",
  "malformed_replies",
  "unexpected_replies",
  "frames_received",
  "frames_ignored",
  "frames_lost",
  "repeats",
  "skipped_bytes",
  "window_bytes",
  "window_commands",
  "reconnections",
];

const CHARTS = [
  { name: "round_trip", unit: "ms", series: [["round_trip_ms", "median"], ["longest_ms", "longest"]] },
  { name: "recoveries", unit: "1/s", series: [["recoveries", "recoveries"]], bars: true },
  { name: "bytes", unit: "B/s", series: [["sent", "sent"], ["received", "received"]] },
];

const colour = (style, name) => style.getPropertyValue(name).trim();

export default {
  props: { state: Object, samples: Object, isShown: Boolean, theme: String, t: Function, language: String },
  data: () => ({ charts: CHARTS, looked: 0, failed: false }),

  computed: {
    figures() {
      const known = this.state.view?.figures ?? {};
      return FIGURES.filter((name) => known[name] != null).map((name) => {
        const isTime = name.endsWith("_s");
        const value = isTime ? known[name] * 1000 : known[name];
        const digits = isTime ? 1 : 0;
        const text = value.toLocaleString(this.language, { maximumFractionDigits: digits });
        return [name, isTime ? `${text} ms` : text];
      });
    },
    mended() {
      return recoveries(this.state.view?.figures ?? {});
    },
    table() {
      void this.looked;
      const { rows } = this.samples;
      const lines = [];
      for (let end = rows.length; end > 0 && lines.length < TABLE_ROWS; end -= TABLE_S) {
        const part = rows.slice(Math.max(0, end - TABLE_S), end);
        const mean = (name) => {
          const values = part.map((row) => row[name]).filter((value) => value != null);
          return values.length ? values.reduce((a, b) => a + b) / values.length : null;
        };
        const say = (value, digits) => (value == null ? "–" : value.toLocaleString(this.language, { maximumFractionDigits: digits }));
        lines.push({
          ago: rows.length - end,
          round_trip: say(mean("round_trip_ms"), 1),
          recoveries: say(part.reduce((sum, row) => sum + row.recoveries, 0), 0),
          sent: say(mean("sent"), 0),
          received: say(mean("received"), 0),
        });
      }
      return lines;
    },
  },

  watch: {
    isShown: "look",
    theme() {
      this.$nextTick(() => this.draw(true));
    },
    language() {
      this.$nextTick(() => this.draw(true));
    },
    samples() {
      this.draw(true);
    },
  },

  async mounted() {
    this.timer = setInterval(() => this.look(), LOOK_MS);
    try {
      this.echarts = (await import("nicegui-echart")).echarts;
    } catch {
      this.failed = true;
      return;
    }
    this.drawn = this.$refs.charts.map((element) => this.echarts.init(element, null, { renderer: "svg" }));
    this.observer = new ResizeObserver(() => {
      for (const chart of this.drawn) if (chart.getDom().clientWidth) chart.resize();
    });
    for (const element of this.$refs.charts) this.observer.observe(element);
    this.draw(true);
  },

  beforeUnmount() {
    clearInterval(this.timer);
    this.observer?.disconnect();
    for (const chart of this.drawn ?? []) chart.dispose();
  },

  methods: {
    look() {
      if (!this.isShown) return;
      this.looked += 1;
      this.draw(false);
    },

    draw(isNew) {
      if (!this.drawn || !this.isShown) return;
      const style = getComputedStyle(this.$el);
      const [ink, line] = [colour(style, "--muted"), colour(style, "--line")];
      const colours = [colour(style, "--chart-1"), colour(style, "--chart-2")];
      const { rows } = this.samples;
      const latest = rows.length ? rows[rows.length - 1].at : 0;
      // the whole minutes that there is something of
      const span = 60 * Math.min(5, Math.max(1, Math.ceil((latest - (rows[0]?.at ?? 0)) / 60)));
      this.charts.forEach(({ series, bars, unit }, index) => {
        const axis = { axisLabel: { color: ink, fontSize: 11 }, axisLine: { lineStyle: { color: line } } };
        this.drawn[index].setOption(
          {
            animation: false,
            textStyle: { fontFamily: "Roboto, system-ui, sans-serif" },
            color: colours,
            grid: { left: 46, right: 12, top: series.length > 1 ? 30 : 14, bottom: 24 },
            legend: { show: series.length > 1, top: 0, right: 8, itemHeight: 8, itemWidth: 14, textStyle: { color: ink, fontSize: 11 } },
            xAxis: {
              ...axis,
              type: "value",
              min: -span,
              max: 0,
              interval: span > 60 ? 60 : 15,
              axisLabel: { ...axis.axisLabel, formatter: (value) => (value ? (span > 60 ? `${value / 60} min` : `${value} s`) : this.t("now")) },
              splitLine: { show: false },
            },
            yAxis: {
              ...axis,
              type: "value",
              min: 0,
              max: bars ? (value) => Math.max(3, value.max) : undefined,
              minInterval: bars ? 1 : 0,
              splitNumber: 3,
              splitLine: { lineStyle: { color: line } },
              axisLabel: { ...axis.axisLabel, formatter: (value) => `${value}` },
            },
            series: series.map(([name, title]) => ({
              name: `${this.t(`chart_${title}`)} (${unit})`,
              type: bars ? "bar" : "line",
              barWidth: 2,
              showSymbol: false,
              lineStyle: { width: 2 },
              data: rows.map((row) => [row.at - latest, row[name]]),
            })),
          },
          { notMerge: isNew },
        );
      });
    },
  },

  template: `
    <section class="tw-charts" :aria-label="t('link')">
      <p v-if="failed" role="alert">{{ t('charts_failed') }}</p>
      <p class="tw-muted">{{ t(mended ? 'link_mended' : 'link_fine', {count: mended}) }}</p>
      <figure v-for="chart in charts" :key="chart.name" class="tw-card">
        <figcaption>{{ t('chart_' + chart.name) }} <span class="tw-muted">{{ chart.unit }}</span></figcaption>
        <div class="tw-chart" ref="charts" aria-hidden="true"></div>
      </figure>
      <details class="tw-card">
        <summary>{{ t('as_table') }}</summary>
        <div class="tw-scroll" tabindex="0" role="region" :aria-label="t('as_table')">
          <table class="tw-table">
            <thead><tr><th scope="col">{{ t('seconds_ago') }}</th><th scope="col">{{ t('chart_round_trip') }}, ms</th>
              <th scope="col">{{ t('chart_recoveries') }}</th><th scope="col">{{ t('chart_sent') }}, B/s</th>
              <th scope="col">{{ t('chart_received') }}, B/s</th></tr></thead>
            <tbody><tr v-for="line in table" :key="line.ago"><th scope="row">{{ line.ago }}</th><td>{{ line.round_trip }}</td>
              <td>{{ line.recoveries }}</td><td>{{ line.sent }}</td><td>{{ line.received }}</td></tr></tbody>
          </table>
        </div>
      </details>
      <details class="tw-card" open>
        <summary>{{ t('figures') }}</summary>
        <dl class="tw-figures"><div v-for="[name, value] in figures" :key="name"><dt>{{ t('figure_' + name) }}</dt><dd>{{ value }}</dd></div></dl>
      </details>
    </section>
  `,
};

// What a program prints, what it reads, and its variables while it stands.

const SHOWN = 20000;
const AGAIN_MS = 100;

export default {
  props: { api: Object, t: Function, path: String, program: Object, drives: Boolean },
  data: () => ({ text: "", known: 0, number: null, isCut: false, line: "", here: "" }),

  computed: {
    written() {
      return [this.path, this.program?.number, this.program?.written];
    },
    asks() {
      return this.program?.phase === "asking";
    },
    variables() {
      return Object.entries(this.program?.paused?.variables ?? {});
    },
  },

  watch: {
    written: { immediate: true, handler: "fetch" },
    async asks(asks) {
      await this.$nextTick();
      if (!asks || !this.drives || !this.$refs.line) return;
      this.$refs.line.focus({ preventScroll: true });
      this.$refs.line.scrollIntoView({ block: "center" });
    },
  },

  methods: {
    // One request at a time, and not too many of them: a program may print on and on.
    async fetch() {
      const { path, program } = this;
      if (this.isFetching || !program) return;
      if (this.number !== program.number || this.of !== path) this.begin(path, program.number);
      if (this.known >= program.written) return;
      this.isFetching = true;
      try {
        const { number, from, text } = await this.api.request("GET", `${path}/output?since=${this.known}`);
        if (path !== this.path || number !== this.number) return;
        if (from > this.known) this.isCut = true;
        const all = this.text + text;
        if (all.length > SHOWN) this.isCut = true;
        const pane = this.$refs.pane;
        const isAtEnd = !pane || pane.scrollTop + pane.clientHeight > pane.scrollHeight - 30;
        this.text = all.slice(-SHOWN);
        this.known = from + [...text].length;
        await this.$nextTick();
        if (isAtEnd && this.$refs.pane) this.$refs.pane.scrollTop = this.$refs.pane.scrollHeight;
      } catch {
        // the next change tries again
      } finally {
        setTimeout(() => {
          this.isFetching = false;
          this.fetch();
        }, AGAIN_MS);
      }
    },

    begin(path, number) {
      this.of = path;
      this.number = number;
      this.known = 0;
      this.text = "";
      this.isCut = false;
    },

    clear() {
      this.text = "";
      this.isCut = this.known > 0;
    },

    async send(path, body) {
      try {
        await this.api.request("POST", `${this.path}/${path}`, body);
        return true;
      } catch (error) {
        this.api.say("warning", this.t.code(error));
        return false;
      }
    },

    async type(text) {
      if (await this.send("input", { text })) this.line = "";
    },

    async act() {
      if (this.here.trim() && (await this.send("do", { source: this.here }))) this.here = "";
    },
  },

  template: `
    <section class="tw-out" :aria-label="t('program_output')">
      <div v-if="variables.length" class="tw-scroll"><table class="tw-table" data-part="variables">
        <thead><tr><th scope="col">{{ t('program_variable') }}</th><th scope="col">{{ t('program_value') }}</th></tr></thead>
        <tbody><tr v-for="[name, value] in variables" :key="name"><td class="tw-mono">:{{ name }}</td><td class="tw-mono">{{ value }}</td></tr></tbody>
      </table></div>
      <form v-if="program?.paused && drives" class="tw-row tw-type" @submit.prevent="act">
        <input class="tw-field tw-mono" v-model="here" :aria-label="t('program_here')" :placeholder="t('program_here')" autocapitalize="off"
          autocomplete="off" spellcheck="false" data-part="here">
        <button class="tw-button small">{{ t('program_do') }}</button></form>
      <header class="tw-row"><h2>{{ t('program_output') }}</h2>
        <button v-if="text" class="tw-button quiet small" @click="clear">{{ t('program_clear') }}</button></header>
      <p v-if="isCut" class="tw-muted">{{ t('program_cut') }}</p>
      <pre v-if="text" ref="pane" class="tw-output tw-mono" role="log" tabindex="0" :aria-label="t('program_output')" data-part="output">{{ text }}</pre>
      <p v-else-if="!asks" class="tw-muted">{{ t('program_no_output') }}</p>
      <form v-if="asks" class="tw-row tw-type" @submit.prevent="type(line)">
        <label class="tw-grow"><span>{{ t('program_asks') }}</span>
          <input ref="line" class="tw-field tw-mono" v-model="line" :disabled="!drives" autocapitalize="off" autocomplete="off"
            spellcheck="false" maxlength="10000" data-part="input"></label>
        <button class="tw-button primary small" :disabled="!drives">{{ t('program_send') }}</button>
        <button type="button" class="tw-button quiet small" :disabled="!drives" @click="type(null)">{{ t('program_no_more') }}</button></form>
    </section>
  `,
};

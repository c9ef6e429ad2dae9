// One line to write a message in, by its text form: what there is, what is wrong and where, and its bytes.

const CHECK_MS = 250;
const MAX_HINTS = 8;
const MAX_BEFORE = 50;
const EXAMPLES = {
  walter: "forward 200",
  simple: "drive_forward 120",
  frame: "engine_forward 0 120; engine_forward 1 120",
};

export default {
  props: { api: Object, robot: String, state: Object, t: Function },

  data: () => ({
    text: "",
    known: [],
    wrong: null, // {text, start, end}
    raw: "",
    isSending: false,
    isWritten: false,
    before: [],
    at: 0,
    hint: 0,
  }),

  computed: {
    address() {
      return `/api/robots/${encodeURIComponent(this.robot)}/messages`;
    },
    // Of a frame, the message that is being written.
    part() {
      return this.text.slice(this.text.lastIndexOf(";") + 1).trimStart();
    },
    word() {
      return this.part.split(/\s+/)[0].toLowerCase();
    },
    message() {
      return this.known.find(({ name }) => name === this.word);
    },
    hints() {
      if (/\s/.test(this.part) || (this.message && !this.isWritten)) return [];
      const { word } = this;
      const rank = (name) => (name.startsWith(word) ? 0 : 1);
      const fitting = this.known.filter(({ name }) => name !== word && name.includes(word));
      return fitting.sort((one, other) => rank(one.name) - rank(other.name)).slice(0, MAX_HINTS);
    },
    example() {
      return EXAMPLES[this.state.info.protocol];
    },
    advice() {
      return this.t(`traffic_advice_${this.state.info.protocol}`);
    },
  },

  watch: {
    robot: { immediate: true, handler: "learn" },
    "state.info.reached": "learn",
    text() {
      this.hint = 0;
      this.raw = "";
      clearTimeout(this.checking);
      this.checking = setTimeout(() => this.check(), CHECK_MS);
    },
  },

  beforeUnmount() {
    clearTimeout(this.checking);
  },

  methods: {
    async learn() {
      const { robot } = this;
      try {
        const known = await this.api.request("GET", this.address);
        if (robot === this.robot) this.known = known;
      } catch {
        // without them there are no hints
      }
    },

    async check() {
      const { text } = this;
      if (!text.trim()) {
        this.wrong = null;
        return;
      }
      try {
        const { bytes, problem } = await this.api.request("POST", `${this.address}/check`, { text });
        if (text !== this.text) return;
        this.raw = bytes?.raw ?? "";
        this.wrong = problem && {
          text: problem.text.replace(/; known are .*/s, ""),
          start: problem.start ?? 0,
          end: problem.end ?? text.length,
        };
      } catch (error) {
        this.api.say("warning", this.t.code(error));
      }
    },

    async send() {
      if (!this.text.trim() || this.isSending) return;
      this.isSending = true;
      clearTimeout(this.checking);
      try {
        await this.check();
        if (this.wrong) return;
        const { text } = this;
        await this.api.takeFreeWheel(this.robot);
        ({ raw: this.raw } = await this.api.request("POST", this.address, { text }));
        this.before = [...this.before.filter((one) => one !== text), text].slice(-MAX_BEFORE);
        this.at = this.before.length;
        this.$refs.input.select();
      } catch (error) {
        this.api.say("warning", this.t.code(error));
      } finally {
        this.isSending = false;
        this.isWritten = false;
      }
    },

    take(name) {
      const start = this.text.length - this.part.length;
      const { fields = [] } = this.known.find((one) => one.name === name) ?? {};
      this.text = `${this.text.slice(0, start)}${name}${fields.length ? " " : ""}`;
      this.isWritten = true;
      this.$refs.input.focus();
    },

    key(event) {
      const { hints } = this;
      if (event.key === "Tab" && !event.shiftKey && this.word && hints.length) {
        event.preventDefault();
        this.take(hints[this.hint].name);
      } else if (event.key === "ArrowDown" || event.key === "ArrowUp") {
        event.preventDefault();
        const by = event.key === "ArrowDown" ? 1 : -1;
        this.at = Math.min(this.before.length, Math.max(0, this.at + by));
        this.text = this.before[this.at] ?? "";
      }
    },

    range({ low, high, unit, choices }) {
      return choices.length ? choices.join(" | ") : `${low}…${high} (${unit})`;
    },
  },

  template: `
    <form class="tw-message" @submit.prevent="send">
      <div class="tw-message-line">
        <input ref="input" class="tw-field tw-mono" type="text" name="message" :aria-label="t('traffic_message')"
          :placeholder="t('traffic_message_as', {example})" autocomplete="off" autocapitalize="off" spellcheck="false" maxlength="2000"
          :aria-invalid="wrong ? 'true' : null" aria-describedby="tw-message-says" v-model="text"
          @input="isWritten = true" @keydown="key">
        <button class="tw-button primary" :disabled="!text.trim() || isSending">{{ t('traffic_send') }}</button>
      </div>
      <div v-if="isWritten && hints.length && word" class="tw-row tw-hints" :aria-label="t('traffic_hints')" role="group">
        <button v-for="({name}, number) in hints" :key="name" type="button" class="tw-button small tw-mono" :title="known.find((one) => one.name === name).about"
          @click="take(name)">{{ name }}</button>
      </div>
      <div id="tw-message-says" role="status">
        <template v-if="wrong">
          <p class="tw-mono tw-wrong-at" aria-hidden="true">{{ text.slice(0, wrong.start) }}<mark>{{
            text.slice(wrong.start, wrong.end) || '▁' }}</mark>{{ text.slice(wrong.end) }}</p>
          <p class="tw-wrong">{{ wrong.text }}</p>
        </template>
        <p v-else-if="raw" class="tw-mono tw-muted tw-bytes">{{ raw }}</p>
        <p v-if="message" class="tw-muted tw-about">{{ message.about }}
          <span v-for="field in message.fields" :key="field.name" class="tw-about-field"><span class="tw-mono">{{ field.name }}</span>
            {{ range(field) }}</span></p>
      </div>
      <details class="tw-muted"><summary>{{ t('traffic_how') }}</summary><p>{{ t('traffic_how_text') }} {{ advice }}</p></details>
    </form>
  `,
};

// Programs: the editor, running, stepping and looking ahead; what runs belongs to the server, and any page may see it.

import { markRaw } from "vue";
import { Editor } from "./editor.js";
import Files from "./program_files.js";
import Foresight from "./program_foresight.js";
import Output from "./program_output.js";

const DRAFT = "turtlewire-program";
const FIRST = { name: "square.logo", text: "; A square. Press Run, and the robot draws it.\nto square :side\n  repeat 4 [\n    fd :side\n    rt 90\n  ]\nend\n\nsquare 150\n" };
const CHECK_MS = 400;
const OVER = ["ended", "failed", "stopped"];
const STEPS = ["into", "over", "out"];

function loadDraft() {
  try {
    const draft = JSON.parse(localStorage.getItem(DRAFT));
    if (typeof draft?.text === "string" && typeof draft.name === "string") return draft;
  } catch {
    // not readable, or not allowed: the first program
  }
  return { ...FIRST, kept: FIRST.text, etag: null };
}

export default {
  components: { Files, Foresight, OutputPart: Output },
  props: { api: Object, robot: String, state: Object, t: Function },

  data() {
    const draft = loadDraft();
    return {
      name: draft.name,
      text: draft.text,
      kept: draft.kept ?? null, // as it was opened or saved
      etag: draft.etag ?? null, // of the version on the server, and the name of that
      opened: draft.opened ?? null,
      findings: [],
      breakpoints: draft.breakpoints ?? [],
      running: null, // {number, source, name} of what runs or ran last
      isBusy: false,
      steps: STEPS,
    };
  },

  computed: {
    program() {
      return this.state.program;
    },
    phase() {
      return this.program?.phase ?? null;
    },
    isRunning() {
      return this.phase !== null && !OVER.includes(this.phase);
    },
    stands() {
      return this.phase === "paused";
    },
    isChanged() {
      return this.text !== this.kept;
    },
    file() {
      const name = this.name.trim() || "program";
      return /\.logo$/i.test(name) ? name : `${name}.logo`;
    },
    // Whether the editor has what runs.
    isShown() {
      return this.running !== null && this.running.number === this.program?.number && this.running.source === this.text;
    },
    line() {
      const { program } = this;
      if (!this.isRunning || !this.isShown || !program.line) return null;
      return program.file === program.name ? program.line : null;
    },
    lineMark() {
      return [this.line, this.stands];
    },
    // What a run that ended by an error has to say.
    error() {
      const error = this.program?.error;
      if (!error) return null;
      const message = error.procedure ? `${error.text} ${this.t("program_in", { procedure: error.procedure })}` : error.text;
      return { ...error, message, level: "error", isHere: this.isShown && error.line && error.file === this.program.name };
    },
    marks() {
      const warnings = this.findings.map((finding) => ({ ...finding, level: "warning" }));
      return this.error?.isHere ? [...warnings, this.error] : warnings;
    },
    says() {
      if (!this.phase) return "";
      const phase = this.t(`program_phase_${this.phase}`);
      const at = this.isRunning && this.program.line ? `, ${this.t("program_at", { line: this.program.line })}` : "";
      return phase + at;
    },
    path() {
      return `/api/robots/${encodeURIComponent(this.robot)}/program`;
    },
    drives() {
      return this.state.drives;
    },
  },

  watch: {
    text() {
      this.keepDraft();
      clearTimeout(this.checking);
      this.checking = setTimeout(() => this.check(), CHECK_MS);
    },
    name: "keepDraft",
    breakpoints: "keepDraft",
    marks(marks) {
      this.editor.show(marks);
    },
    lineMark([line, stands]) {
      this.editor.runs(line, stands);
    },
    "program.number": { handler: "meet" },
    robot: { handler: "meet" },
    t(t) {
      this.editor.speak(t);
    },
  },

  created() {
    this.words = [];
  },

  mounted() {
    this.editor = markRaw(
      new Editor(this.$refs.editor, {
        text: this.text,
        words: () => this.words,
        t: this.t,
        act: {
          changed: (text) => {
            this.text = text;
          },
          run: () => this.run(false),
          save: () => this.$refs.files.save(),
          breakpoints: (lines) => this.setBreakpoints(lines),
        },
      }),
    );
    this.editor.breakpoints = this.breakpoints;
    this.learn();
    this.check();
    this.meet();
  },

  beforeUnmount() {
    clearTimeout(this.checking);
    this.editor.close();
  },

  methods: {
    async learn() {
      try {
        this.words = await this.api.request("GET", "/api/logo/words");
        this.editor.learned();
      } catch {
        setTimeout(() => this.learn(), 5000);
      }
    },

    keepDraft() {
      const { name, text, kept, etag, opened, breakpoints } = this;
      try {
        localStorage.setItem(DRAFT, JSON.stringify({ name, text, kept, etag, opened, breakpoints }));
      } catch {
        // a private window may have no room for it
      }
    },

    // A program that was opened or saved.
    take({ name, source, etag }) {
      this.name = name;
      this.kept = source;
      this.etag = etag;
      this.opened = name;
      this.editor.text = source;
      this.keepDraft();
    },

    async check() {
      const { text } = this;
      try {
        const findings = await this.api.request("POST", "/api/check", { source: text, name: this.file });
        if (text === this.text) this.findings = findings;
      } catch (error) {
        if (error.status !== 429 && error.status !== 0) throw error;
        clearTimeout(this.checking);
        this.checking = setTimeout(() => this.check(), 10 * CHECK_MS);
      }
    },

    // What runs on this robot, or ran last: its source.
    async meet() {
      const number = this.program?.number;
      if (number == null || this.running?.number === number) {
        if (number == null) this.running = null;
        return;
      }
      try {
        const told = await this.api.request("GET", this.path);
        if (!told) return;
        this.running = { number: told.number, source: told.source, name: told.name };
        if (this.isRunning && !this.isShown && !this.isChanged) this.showRunning();
      } catch {
        this.running = null;
      }
    },

    showRunning() {
      const { name, source } = this.running;
      if (this.isChanged && !window.confirm(`${this.t("program_discard")} ${this.t("program_discard_says", { name: this.file })}`)) return;
      this.take({ name, source, etag: null });
      this.editor.breakpoints = this.program.breakpoints;
      this.breakpoints = this.editor.breakpoints;
    },

    // ------------------------------------------------------------ running

    async ask(method, path, body) {
      if (this.isBusy) return null;
      this.isBusy = true;
      try {
        return await this.api.request(method, path, body);
      } catch (error) {
        this.api.say("warning", this.t.code(error));
        return null;
      } finally {
        this.isBusy = false;
      }
    },

    // Whether this page has the wheel; one that is free is taken, except after somebody else's stop.
    async takeWheel() {
      if (this.drives) return true;
      const { wheel } = this.state;
      if (wheel?.driver != null) {
        this.api.say("warning", this.t("program_needs_wheel"));
        return false;
      }
      if (wheel?.barred?.includes(this.api.store.id)) {
        this.api.say("warning", this.t("program_barred"));
        return false;
      }
      const taken = await this.ask("POST", `/api/robots/${encodeURIComponent(this.robot)}/wheel`, { action: "take" });
      return taken !== null;
    },

    async run(paused) {
      if (this.isRunning || this.isBusy || !(await this.takeWheel())) return;
      const { text: source, file: name } = this;
      this.$refs.foresight.forget();
      this.breakpoints = this.editor.breakpoints;
      const begun = await this.ask("POST", this.path, { source, name, paused, breakpoints: this.breakpoints });
      if (begun) this.running = { number: begun.number, source, name };
    },

    pause() {
      return this.ask("POST", `${this.path}/pause`);
    },
    goOn() {
      return this.ask("POST", `${this.path}/continue`);
    },
    step(how) {
      return this.ask("POST", `${this.path}/step`, { how });
    },
    end() {
      this.isBusy = false; // nothing keeps anybody from this
      return this.drives ? this.ask("POST", `${this.path}/stop`) : this.api.stop(this.robot);
    },

    setBreakpoints(lines) {
      this.breakpoints = lines;
      if (this.isRunning && this.isShown && this.drives) {
        this.api.request("PUT", `${this.path}/breakpoints`, { lines }).catch((error) => this.api.say("warning", this.t.code(error)));
      }
    },

    goTo(finding) {
      this.editor.goTo(finding);
    },
  },

  template: `
    <div class="tw-program">
      <files ref="files" :api="api" :t="t" v-model:name="name" :file="file" :text="text" :etag="etag" :opened="opened" :is-changed="isChanged"
        @take="take"></files>
      <div class="tw-row tw-run">
        <template v-if="!isRunning">
          <button class="tw-button primary small" data-act="run" :disabled="isBusy" @click="run(false)">
            <tw-icon name="resume"/>{{ t('program_run') }}</button>
          <button class="tw-button small" data-act="step-first" :title="t('program_step_help')" :disabled="isBusy" @click="run(true)">
            {{ t('program_step_first') }}</button>
          <button class="tw-button small" data-act="preview" @click="$refs.foresight.look()">
            <tw-icon name="eye"/>{{ t('program_preview') }}</button>
        </template>
        <template v-else>
          <button v-if="stands" class="tw-button primary small" data-act="continue" :disabled="!drives || isBusy" @click="goOn">
            <tw-icon name="resume"/>{{ t('program_continue') }}</button>
          <button v-else class="tw-button small" data-act="pause" :disabled="!drives || phase !== 'running'" @click="pause">
            <tw-icon name="pause"/>{{ t('program_pause') }}</button>
          <button v-for="how in steps" v-show="stands" :key="how" class="tw-button small" :data-act="how" :title="t('program_' + how + '_help')"
            :disabled="!drives || isBusy" @click="step(how)">{{ t('program_' + how) }}</button>
          <button class="tw-button small tw-end" data-act="end" :title="t('program_end_help')" @click="end">
            <tw-icon name="end"/>{{ t('program_end') }}</button>
        </template>
        <span v-if="phase" class="tw-phase" :class="phase" role="status">{{ says }}</span>
      </div>
      <p v-if="isRunning && running && !isShown" class="tw-note">
        <span>{{ running.name === file ? t('program_edited') : t('program_other', {name: running.name}) }}</span>
        <button class="tw-button small" data-act="show-running" @click="showRunning">{{ t('program_show_other') }}</button></p>
      <p v-if="error" class="tw-note error" role="alert" data-part="error">
        <span><button v-if="error.isHere" class="tw-place" @click="goTo(error)">{{ t('program_line', {line: error.line}) }}</button>
        {{ error.message }} <span v-if="error.number" class="tw-muted">({{ t('program_number', {number: error.number}) }})</span>
        <small v-if="error.hint">{{ error.hint }}</small></span></p>
      <div class="tw-editor" ref="editor" data-part="editor"></div>
      <section v-if="findings.length" class="tw-findings" :aria-label="t('program_findings')" data-part="findings">
        <h2>{{ t('program_findings') }}</h2>
        <ul><li v-for="(finding, index) in findings" :key="index">
          <button class="tw-place" @click="goTo(finding)">{{ t('program_line', {line: finding.line}) }}</button>
          <span>{{ finding.message }}<small v-if="finding.hint">{{ finding.hint }}</small></span></li></ul>
      </section>
      <foresight ref="foresight" :api="api" :t="t" :robot="robot" :text="text" :file="file" @place="goTo"></foresight>
      <output-part :api="api" :t="t" :path="path" :program="program" :drives="drives"></output-part>
    </div>
  `,
};

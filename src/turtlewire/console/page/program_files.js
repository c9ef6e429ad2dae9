// Programs opened from the server's folder, or from the examples, and saved there; nobody's work is lost by it.

export default {
  props: { api: Object, t: Function, name: String, file: String, text: String, etag: String, opened: String, isChanged: Boolean },
  emits: ["take", "update:name"],
  // asks: what is to be answered first, {title, says, choices: [{key, label, kind}]}
  data: () => ({ programs: [], examples: [], asks: null }),

  methods: {
    path(name) {
      return `/api/programs/${encodeURIComponent(name)}`;
    },

    async attempt(work) {
      try {
        return await work();
      } catch (error) {
        this.api.say("warning", this.t.code(error));
        return null;
      }
    },

    // The answer to a question: the key of a choice, or "" for none.
    ask(title, says, choices) {
      this.asks = { title, says, choices };
      this.$refs.question.showModal();
      return new Promise((answer) => {
        this.answered = answer;
      });
    },
    answer(key) {
      const { answered } = this;
      this.answered = null;
      if (this.$refs.question.open) this.$refs.question.close();
      answered?.(key);
    },

    async mayLeave() {
      if (!this.isChanged) return true;
      const leave = { key: "leave", label: this.t("program_discard_do"), kind: "danger" };
      return (await this.ask(this.t("program_discard"), this.t("program_discard_says", { name: this.file }), [leave])) === "leave";
    },

    // ------------------------------------------------------------ opening

    async choose() {
      await this.attempt(async () => {
        [this.programs, this.examples] = await Promise.all([this.api.request("GET", "/api/programs"), this.api.request("GET", "/api/examples")]);
        this.$refs.list.showModal();
      });
    },

    async open(path, isKept) {
      this.$refs.list.close();
      if (!(await this.mayLeave())) return;
      const found = await this.attempt(() => this.api.request("GET", path));
      if (found) this.$emit("take", { ...found, etag: isKept ? found.etag : null });
    },

    async begin() {
      if (await this.mayLeave()) this.$emit("take", { name: "program.logo", source: "", etag: null });
    },

    async remove(name) {
      const sure = { key: "delete", label: this.t("program_delete", { name }), kind: "danger" };
      if ((await this.ask(this.t("program_delete_sure", { name }), "", [sure])) !== "delete") return;
      await this.attempt(async () => {
        const { etag } = await this.api.request("GET", this.path(name));
        await this.api.request("DELETE", this.path(name), undefined, { "If-Match": etag });
        this.programs = this.programs.filter((program) => program.name !== name);
        this.api.say("good", this.t("program_deleted", { name }));
      });
    },

    // ------------------------------------------------------------ saving

    // A program that got another name is another one: what is kept under that name is not overwritten unasked.
    async save(etag = this.file === this.opened ? this.etag : null) {
      const { file: name, text: source } = this;
      try {
        const saved = await this.api.request("PUT", this.path(name), { source }, etag ? { "If-Match": etag } : {});
        this.$emit("take", { name, source, etag: saved.etag });
        this.api.say("good", this.t("program_saved", { name }));
      } catch (error) {
        if (error.status === 412) await this.settle(name, error.code);
        else this.api.say("warning", this.t.code(error));
      }
    },

    // Another version is there than the one that was opened.
    async settle(name, code) {
      const choices = [{ key: "mine", label: this.t("program_overwrite"), kind: "danger" }];
      if (code !== "gone") choices.unshift({ key: "theirs", label: this.t("program_theirs"), kind: "" });
      const key = await this.ask(this.t("program_conflict"), this.t(`program_conflict_${code}`, { name }), choices);
      if (!key) return;
      const there = code === "gone" ? null : await this.attempt(() => this.api.request("GET", this.path(name)));
      if (key === "mine") await this.save(there?.etag ?? null);
      else if (there) this.$emit("take", there);
    },
  },

  template: `
    <div class="tw-row tw-files">
      <label class="tw-grow"><span class="tw-hidden">{{ t('program_name') }}</span>
        <input class="tw-field" type="text" maxlength="64" autocomplete="off" spellcheck="false" data-part="name" :value="name"
          @input="$emit('update:name', $event.target.value)"></label>
      <span v-if="isChanged" class="tw-unsaved" :title="t('program_unsaved')"><i></i><span class="tw-hidden">{{ t('program_unsaved') }}</span></span>
      <button class="tw-button small" data-act="new" @click="begin">{{ t('program_new') }}</button>
      <button class="tw-button small" data-act="open" @click="choose">{{ t('program_open') }}</button>
      <button class="tw-button small" data-act="save" @click="save()">{{ t('program_save') }}</button>
    </div>
    <dialog ref="list" class="tw-dialog tw-list" :aria-label="t('program_open')">
      <h2>{{ t('program_saved_here') }}</h2>
      <p v-if="!programs.length" class="tw-muted">{{ t('program_none') }}</p>
      <ul data-part="programs"><li v-for="program in programs" :key="program.name" class="tw-row">
        <button class="tw-button quiet" @click="open(path(program.name), true)">{{ program.name }}</button>
        <button class="tw-tool plain" :aria-label="t('program_delete', {name: program.name})" @click="remove(program.name)"><tw-icon name="close"/></button></li></ul>
      <h2>{{ t('program_examples') }}</h2>
      <ul data-part="examples"><li v-for="example in examples" :key="example">
        <button class="tw-button quiet" @click="open('/api/examples/' + encodeURIComponent(example), false)">{{ example }}</button></li></ul>
      <div class="tw-row end"><button class="tw-button" @click="$refs.list.close()">{{ t('close') }}</button></div>
    </dialog>
    <dialog ref="question" class="tw-dialog" aria-labelledby="tw-question" @close="answer('')">
      <template v-if="asks"><h2 id="tw-question">{{ asks.title }}</h2><p v-if="asks.says">{{ asks.says }}</p>
        <div class="tw-row end"><button class="tw-button" @click="answer('')">{{ t('program_cancel') }}</button>
          <button v-for="choice in asks.choices" :key="choice.key" class="tw-button" :class="choice.kind" :data-answer="choice.key"
            @click="answer(choice.key)">{{ choice.label }}</button></div></template>
    </dialog>
  `,
};

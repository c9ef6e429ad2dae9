// The editor of programs: CodeMirror with Logo in it, marks where something is wrong, and the line that runs.

import {
  Compartment,
  Decoration,
  EditorState,
  EditorView,
  GutterMarker,
  RangeSet,
  StateEffect,
  StateField,
  basicSetup,
  gutter,
  hoverTooltip,
  indentUnit,
  indentWithTab,
  keymap,
  syntaxHighlighting,
  tooltips,
} from "nicegui-codemirror";
import { logoLanguage } from "./logo.js";

const setFindings = StateEffect.define();
const setRunning = StateEffect.define();
const toggleBreakpoint = StateEffect.define();
const setBreakpoints = StateEffect.define();

class Dot extends GutterMarker {
  toDOM() {
    const dot = document.createElement("span");
    dot.className = "tw-dot";
    return dot;
  }
}
const DOT = new Dot();

// Where a finding begins and ends; the server counts whole characters.
function spanOf(doc, { line, column }) {
  if (!line) return null;
  const { from, to, text } = doc.line(Math.min(line, doc.lines));
  const start = from + [...text].slice(0, Math.max(0, (column ?? 1) - 1)).join("").length;
  const word = /^(?:"?\|[^|]*\||[":]?[^\s[\](){}]+|.)/u.exec(text.slice(start - from));
  const end = Math.min(to, start + Math.max(1, word ? word[0].length : 1));
  return start < end ? [start, end] : [Math.max(from, to - 1), to];
}

const findingField = StateField.define({
  create: () => ({ findings: [], marks: Decoration.none }),
  update(value, transaction) {
    let { findings, marks } = value;
    if (transaction.docChanged) marks = marks.map(transaction.changes);
    for (const effect of transaction.effects) {
      if (!effect.is(setFindings)) continue;
      findings = effect.value;
      const ranges = [];
      for (const finding of findings) {
        const span = spanOf(transaction.state.doc, finding);
        if (!span || span[0] === span[1]) continue;
        ranges.push(Decoration.mark({ class: `tw-finding ${finding.level}`, finding }).range(...span));
      }
      marks = Decoration.set(ranges, true);
    }
    return { findings, marks };
  },
  provide: (field) => EditorView.decorations.from(field, ({ marks }) => marks),
});

const runningField = StateField.define({
  create: () => Decoration.none,
  update(marks, transaction) {
    let found = transaction.docChanged ? marks.map(transaction.changes) : marks;
    for (const effect of transaction.effects) {
      if (!effect.is(setRunning)) continue;
      const { line, stands } = effect.value;
      found =
        line && line <= transaction.state.doc.lines
          ? Decoration.set([
              Decoration.line({ class: stands ? "tw-line-runs stands" : "tw-line-runs", attributes: { "aria-current": "step" } }).range(
                transaction.state.doc.line(line).from,
              ),
            ])
          : Decoration.none;
    }
    return found;
  },
  provide: (field) => EditorView.decorations.from(field),
});

const breakpointField = StateField.define({
  create: () => RangeSet.empty,
  update(set, transaction) {
    let found = set.map(transaction.changes);
    const { doc } = transaction.state;
    for (const effect of transaction.effects) {
      if (effect.is(toggleBreakpoint)) {
        const from = effect.value;
        let has = false;
        found.between(from, from, () => {
          has = true;
        });
        found = found.update(has ? { filter: (at) => at !== from } : { add: [DOT.range(from)] });
      } else if (effect.is(setBreakpoints)) {
        const lines = effect.value.filter((line) => line <= doc.lines);
        found = RangeSet.of(lines.map((line) => DOT.range(doc.line(line).from)), true);
      }
    }
    return found;
  },
});

function linesOf(state) {
  const lines = new Set();
  const cursor = state.field(breakpointField).iter();
  for (; cursor.value; cursor.next()) lines.add(state.doc.lineAt(cursor.from).number);
  return [...lines].sort((a, b) => a - b);
}

const tooltip = hoverTooltip((view, pos) => {
  let found = null;
  view.state.field(findingField).marks.between(pos, pos, (from, to, mark) => {
    found = { pos: from, end: to, finding: mark.spec.finding };
  });
  if (!found) return null;
  const { pos: at, end, finding } = found;
  return {
    pos: at,
    end,
    above: true,
    create() {
      const dom = document.createElement("div");
      dom.className = `tw-tip ${finding.level}`;
      for (const text of [finding.message, finding.hint].filter(Boolean)) {
        const line = document.createElement("p");
        line.textContent = text;
        dom.append(line);
      }
      return { dom };
    },
  };
});

// Nothing covers the stop, or is covered by it: tooltips keep to the panel.
const inPanel = tooltips({
  tooltipSpace(view) {
    const panel = view.dom.closest(".tw-panel") ?? document.documentElement;
    const { top, left, bottom, right } = panel.getBoundingClientRect();
    const free = bottom - (parseFloat(getComputedStyle(panel).paddingBottom) || 0);
    const cursor = view.coordsAtPos(view.state.selection.main.head)?.bottom ?? 0;
    return { top, left, bottom: Math.min(bottom, Math.max(free, cursor + 1)), right };
  },
});

// Tags have names; colours are those of the page.
const highlighter = { style: (tags) => tags.map((tag) => `tok-${tag.toString()}`).join(" ") };

export class Editor {
  // words(), t(): see logo.js; act: {changed, run, save, breakpoints}
  constructor(parent, { text, words, t, act }) {
    this.label = new Compartment();
    this.language = new Compartment();
    this.words = words;
    this.t = t;
    this.act = act;
    const toggle = (view, at) => {
      view.dispatch({ effects: toggleBreakpoint.of(view.state.doc.lineAt(at).from) });
      act.breakpoints(linesOf(view.state));
      return true;
    };
    this.view = new EditorView({
      parent,
      state: EditorState.create({
        doc: text,
        extensions: [
          keymap.of([
            { key: "Mod-Enter", run: () => (act.run(), true) },
            { key: "Mod-s", run: () => (act.save(), true), preventDefault: true },
            { key: "F9", run: (view) => toggle(view, view.state.selection.main.head) },
          ]),
          breakpointField,
          gutter({
            class: "tw-breakpoints",
            markers: (view) => view.state.field(breakpointField),
            initialSpacer: () => DOT,
            domEventHandlers: { mousedown: (view, block) => toggle(view, block.from) },
          }),
          basicSetup,
          keymap.of([indentWithTab]),
          indentUnit.of("  "),
          this.language.of(this.logo()),
          syntaxHighlighting(highlighter),
          findingField,
          runningField,
          tooltip,
          inPanel,
          EditorView.lineWrapping,
          this.label.of(this.labels(t)),
          EditorView.updateListener.of((update) => {
            if (update.docChanged) act.changed(update.state.doc.toString());
          }),
        ],
      }),
    });
  }

  logo() {
    return logoLanguage(this.words, () => this.t);
  }

  // There are other words now: look at all of the text again.
  learned() {
    this.view.dispatch({ effects: this.language.reconfigure(this.logo()) });
  }

  labels(t) {
    return [
      EditorView.contentAttributes.of({
        "aria-label": t("program_editor"),
        autocapitalize: "off",
        autocorrect: "off",
        spellcheck: "false",
      }),
      EditorState.phrases.of(
        t.language === "sv"
          ? {
              "Fold line": "Fäll ihop",
              "Unfold line": "Fäll ut",
              Find: "Sök",
              Replace: "Ersätt",
              next: "nästa",
              previous: "föregående",
              all: "alla",
              "match case": "skiftläge",
              "by word": "hela ord",
              regexp: "reguljärt uttryck",
              replace: "ersätt",
              "replace all": "ersätt alla",
              close: "stäng",
              Completions: "Förslag",
            }
          : {},
      ),
    ];
  }

  speak(t) {
    this.t = t;
    this.view.dispatch({ effects: this.label.reconfigure(this.labels(t)) });
  }

  get text() {
    return this.view.state.doc.toString();
  }

  set text(text) {
    const { doc } = this.view.state;
    if (doc.toString() === text) return;
    this.view.dispatch({ changes: { from: 0, to: doc.length, insert: text }, selection: { anchor: 0 }, scrollIntoView: true });
  }

  get breakpoints() {
    return linesOf(this.view.state);
  }

  set breakpoints(lines) {
    this.view.dispatch({ effects: setBreakpoints.of(lines) });
  }

  // [{line, column, level: "warning" or "error", message, hint}]
  show(findings) {
    this.view.dispatch({ effects: setFindings.of(findings) });
  }

  // The line that runs, or before which the program stands; null: none.
  runs(line, stands) {
    const { view } = this;
    const effects = [setRunning.of({ line, stands })];
    if (line && line <= view.state.doc.lines) {
      effects.push(EditorView.scrollIntoView(view.state.doc.line(line).from, { y: "nearest", yMargin: 84 }));
    }
    view.dispatch({ effects });
  }

  goTo({ line, column }) {
    const span = spanOf(this.view.state.doc, { line, column });
    if (!span) return;
    this.view.dispatch({ selection: { anchor: span[0] }, effects: EditorView.scrollIntoView(span[0], { y: "center" }) });
    this.view.focus();
  }

  close() {
    this.view.destroy();
  }
}

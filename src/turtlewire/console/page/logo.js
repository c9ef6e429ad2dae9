// Logo for the editor: what its words look like, how lines are indented, and what a half-written word can become.

import { StreamLanguage } from "nicegui-codemirror";

// What a word ends at; a quoted one does not end at an operator.
const WORD = /[^\s[\](){}+\-*/=<>;"|]/;
const ENDS = /[\s[\](){};]/;
const NUMBER = /^-?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?(?=$|[\s[\](){};+\-*/=<>])/i;
const BEGINS = ["to", ".macro"];
const CONTROL = new Set(
  ("if ifelse test iftrue ift iffalse iff repeat forever for while until do.while do.until case cond catch throw stop " +
    "output op .maybeoutput run runresult goto tag foreach map map.se filter find reduce crossmap cascade transfer apply invoke " +
    "local localmake global make name pause continue wait onlimit onstop tell ask each")
    .split(" "),
);
// Where a name that is to be completed begins.
const BEGUN = /(?:[:"])?[^\s[\](){}+\-*/=<>;"|:]*$/;
const ENOUGH = 2;
const MOST = 60;

// Reads a quoted word or what is left of one: bars and backslashes hide what would end it.
function quoted(stream, state) {
  while (!stream.eol()) {
    const c = stream.peek();
    if (c === "\\") stream.next();
    else if (c === "|") state.bar = !state.bar;
    else if (!state.bar && ENDS.test(c)) break;
    stream.next();
  }
  return "string";
}

function token(stream, state, isPrimitive) {
  if (state.bar) return quoted(stream, state);
  if (stream.sol()) state.titled = "";
  if (stream.eatSpace()) return null;
  const c = stream.peek();
  if (c === ";") {
    stream.skipToEnd();
    return "comment";
  }
  if (c === '"' || c === "|") {
    stream.next();
    if (c === "|") state.bar = true;
    return quoted(stream, state);
  }
  if (c === ":") {
    stream.next();
    stream.eatWhile(WORD);
    return "variableName";
  }
  if (stream.match(NUMBER)) return "number";
  if (/[[\](){}]/.test(c)) {
    stream.next();
    if ("[({".includes(c)) state.depth += 1;
    else state.depth = Math.max(0, state.depth - 1);
    return "bracket";
  }
  if (!WORD.test(c)) {
    stream.next();
    return "operator";
  }
  stream.eatWhile((each) => WORD.test(each) || each === "\\");
  const word = stream.current().toLowerCase();
  if (state.titled) {
    state.titled = "";
    return "className";
  }
  if (BEGINS.includes(word)) {
    state.titled = word;
    state.inside = true;
    return "keyword";
  }
  if (word === "end") {
    state.inside = false;
    state.depth = 0;
    return "keyword";
  }
  if (CONTROL.has(word)) return "keyword";
  return isPrimitive(word) ? "typeName" : "name";
}

// words(): the primitives, [{name, inputs, fewest, most, help}]; t(): the translator.
export function logoLanguage(words, t) {
  let known = null;
  const isPrimitive = (word) => {
    if (known?.size !== words().length) known = new Set(words().map(({ name }) => name));
    return known.has(word);
  };
  return StreamLanguage.define({
    name: "logo",
    startState: () => ({ bar: false, depth: 0, inside: false, titled: "" }),
    copyState: (state) => ({ ...state }),
    token: (stream, state) => token(stream, state, isPrimitive),
    indent: (state, after, { unit }) => {
      const closes = /^\s*[\])}]/.test(after) ? 1 : 0;
      const body = state.inside && !/^\s*end\b/i.test(after) ? 1 : 0;
      return unit * (body + Math.max(0, state.depth - closes));
    },
    languageData: {
      commentTokens: { line: ";" },
      closeBrackets: { brackets: ["(", "[", "{"] },
      indentOnInput: /^\s*(?:end|[\])}])$/i,
      autocomplete: (context) => complete(context, words(), t()),
    },
  });
}

// The program's own procedures, with their inputs, and its variables.
export function names(text) {
  const procedures = new Map();
  const variables = new Set();
  for (const [, name, inputs] of text.matchAll(/^[ \t]*(?:to|\.macro)[ \t]+(\S+)([^\n;]*)/gim)) {
    procedures.set(name.toLowerCase(), inputs.trim().replace(/\s+/g, " "));
  }
  for (const [, name] of text.matchAll(/:([^\s[\](){}+\-*/=<>;"|:]+)/g)) variables.add(name.toLowerCase());
  for (const [, name] of text.matchAll(/\b(?:make|local|localmake|global)[ \t]+"([^\s[\](){};]+)/gi)) {
    variables.add(name.toLowerCase());
  }
  return { procedures, variables };
}

function complete(context, words, t) {
  const line = context.state.doc.lineAt(context.pos);
  const before = line.text.slice(0, context.pos - line.from);
  const [begun] = before.match(BEGUN);
  const sign = /^[:"]/.test(begun) ? begun[0] : "";
  const stem = begun.slice(sign.length).toLowerCase();
  if (!context.explicit && (sign === '"' || stem.length < (sign ? 0 : ENOUGH))) return null;
  if (/;/.test(before)) return null;
  const own = names(context.state.doc.toString());
  let options;
  if (sign) {
    own.variables.delete(stem); // what is being written
    options = [...own.variables].map((label) => ({ label, type: "variable" }));
  } else {
    options = [
      ...[...own.procedures].map(([label, inputs]) => ({ label, type: "function", detail: inputs, info: t("program_own"), boost: 1 })),
      ...words.map((word) => ({ label: word.name, type: "keyword", detail: inputsOf(word, t), info: word.help || undefined })),
    ];
  }
  options = options.filter(({ label }) => label.startsWith(stem));
  // A word that is whole needs no help, and the Enter key behind it is a new line.
  if (!context.explicit && options.some(({ label }) => label === stem)) return null;
  if (!options.length) return null;
  const isUpper = stem.length > 1 && begun.slice(sign.length) === stem.toUpperCase() && /[a-z]/.test(stem);
  if (isUpper) options = options.map((option) => ({ ...option, label: option.label.toUpperCase() }));
  options.sort((a, b) => (b.boost ?? 0) - (a.boost ?? 0) || a.label.localeCompare(b.label));
  return { from: context.pos - stem.length, options: options.slice(0, MOST), filter: false };
}

export function inputsOf({ inputs, fewest, most }, t) {
  if (most < 0) return t("program_inputs_any", { count: inputs });
  if (fewest !== most) return t("program_inputs_some", { fewest, most });
  return t(inputs === 1 ? "program_input" : "program_inputs", { count: inputs });
}

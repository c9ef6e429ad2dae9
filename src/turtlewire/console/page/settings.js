// What a person chose, kept by the browser.

import { LAYOUTS } from "./keys.js";
import { LANGUAGES, preferred } from "./texts.js";

export const THEMES = ["auto", "light", "dark"];
const KEY = "turtlewire";

// Each setting: what it is to begin with, and what it may be.
const SETTINGS = {
  name: ["", (value) => typeof value === "string" && value.length <= 30],
  language: [null, (value) => value in LANGUAGES],
  theme: ["auto", (value) => THEMES.includes(value)],
  layout: ["wasd", (value) => value in LAYOUTS],
  hand: ["stick", (value) => value === "stick" || value === "pad"],
  speed: [0.5, (value) => value >= 0.05 && value <= 1],
  turn: [0.5, (value) => value >= 0.05 && value <= 1],
};

export function loadSettings() {
  let kept = {};
  try {
    kept = JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    // not readable, or not allowed: as to begin with
  }
  const settings = {};
  for (const [name, [first, isFine]] of Object.entries(SETTINGS)) {
    settings[name] = name in kept && isFine(kept[name]) ? kept[name] : first;
  }
  settings.language ??= preferred();
  return settings;
}

export function saveSettings(settings) {
  try {
    localStorage.setItem(KEY, JSON.stringify(settings));
  } catch {
    // a private window may have no room for it: they hold until it is closed
  }
}

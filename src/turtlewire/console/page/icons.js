// The page's few icons, drawn by strokes in a square of 24.

import { h } from "vue";

const PATHS = {
  plus: "M12 5v14M5 12h14",
  minus: "M5 12h14",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  follow: "M12 3v4M12 17v4M3 12h4M17 12h4M12 8.5a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z",
  save: "M12 4v11M7 11l5 5 5-5M5 20h14",
  drive: "M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5zM3.4 10.5 9.5 11.5M20.6 10.5 14.5 11.5M12 14.5V21",
  program: "M8 7l-5 5 5 5M16 7l5 5-5 5M13.5 5l-3 14",
  traffic: "M4 8h15M15 4l4 4-4 4M20 16H5M9 12l-4 4 4 4",
  link: "M4 19V9M10 19V5M16 19v-7M21 19H3",
  gear: "M4 7h9M19 7h1M4 17h1M11 17h9M16 4.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5zM8 14.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5z",
  eye: "M2.5 12S6 5.5 12 5.5 21.5 12 21.5 12 18 18.5 12 18.5 2.5 12 2.5 12zM12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5z",
  pen: "M4 20l1-4L16.5 4.5l3 3L8 19zM14 7l3 3",
  lamp: "M9 18h6M10 21h4M12 3a6 6 0 0 0-3.5 10.9c.6.5 1 1.2 1 2.1h5c0-.9.4-1.6 1-2.1A6 6 0 0 0 12 3z",
  horn: "M4 10v4h3l6 4V6L7 10zM16.5 9a4 4 0 0 1 0 6M19 6.5a8 8 0 0 1 0 11",
  clean: "M5 4h14v12l-4 4H5zM15 20v-4h4",
  resume: "M7 5l11 7-11 7z",
  pause: "M8 5v14M16 5v14",
  end: "M6 6h12v12H6z",
  close: "M6 6l12 12M18 6L6 18",
  up: "M12 19V5M6 11l6-6 6 6",
  down: "M12 5v14M6 13l6 6 6-6",
  left: "M19 12H5M11 6l-6 6 6 6",
  right: "M5 12h14M13 6l6 6-6 6",
  warning: "M12 4 2.5 20h19zM12 10v4.5M12 17.2v.3",
  note: "M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18zM12 11v5M12 7.8v.3",
  good: "M5 12.5l4.5 4.5L19 7.5",
  map: "M4 6l5-2 6 2 5-2v14l-5 2-6-2-5 2zM9 4v14M15 6v14",
};
PATHS.error = PATHS.warning;

export default {
  props: { name: String },
  setup: (props) => () =>
    h(
      "svg",
      {
        class: "tw-icon",
        viewBox: "0 0 24 24",
        fill: "none",
        stroke: "currentColor",
        "stroke-width": 1.9,
        "stroke-linecap": "round",
        "stroke-linejoin": "round",
        "aria-hidden": "true",
        focusable: "false",
      },
      [h("path", { d: PATHS[props.name] })],
    ),
};

// The touch joystick: nipplejs, with a dead zone; to hold it is one source of the grip.

import { nipplejs } from "nicegui-joystick";
import { live } from "./gamepad.js";

const SOURCE = "joystick";

export default {
  props: { grip: Object, isHeld: Boolean, t: Function },
  data: () => ({ size: 0 }),

  mounted() {
    this.observer = new ResizeObserver(() => this.build());
    this.observer.observe(this.$refs.zone);
  },

  beforeUnmount() {
    this.observer.disconnect();
    this.grip.release(SOURCE);
    this.stick?.destroy();
  },

  methods: {
    build() {
      const size = Math.floor(Math.min(this.$refs.zone.clientWidth, this.$refs.zone.clientHeight));
      if (!size || size === this.size) return;
      this.size = size;
      this.grip.release(SOURCE);
      this.stick?.destroy();
      this.stick = nipplejs.create({
        zone: this.$refs.zone,
        mode: "static",
        position: { left: "50%", top: "50%" },
        size: size * 0.9,
        restOpacity: 1,
        fadeTime: 80,
        dynamicPage: true,
      });
      this.stick.on("start", () => this.grip.press(SOURCE, { speed: 0, turn: 0, analog: true }));
      this.stick.on("move", (_, { vector }) => {
        this.grip.change(SOURCE, { speed: live(vector.y), turn: live(vector.x), analog: true });
      });
      this.stick.on("end", () => this.grip.release(SOURCE));
    },
  },

  template: `
    <div class="tw-stick" :class="{held: isHeld}" ref="zone" role="img" @contextmenu.prevent :aria-label="t('joystick')"></div>
  `,
};

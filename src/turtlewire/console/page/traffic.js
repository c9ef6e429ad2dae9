export default {
  props: { api: Object, robot: String, state: Object, t: Function },
  template: `<div></div>`,
};

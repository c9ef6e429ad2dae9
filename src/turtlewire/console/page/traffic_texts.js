export default {
  en: {},
  sv: {},
};

// The one component of the page. Its modules are in page/, and import one another relatively.
export { default } from "turtlewire-console/console.js";

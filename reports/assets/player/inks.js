// Colours of the theme as numbers, and the small helpers of the page's own elements.
const Inks = (() => {
  const known = new Map(); // asking the style sheet for each frame would cost more than the frame

  /** The custom property of the style sheet as [red, green, blue] in 0..1. */
  const of = (name) => {
    if (!known.has(name)) {
      const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
      known.set(name, [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255));
    }
    return known.get(name);
  };
  const mixed = (a, b, part) => a.map((v, k) => v + part * (b[k] - v));

  /** An engine's colour on a solid: black and white show no light and shade, a little grey does. */
  const solid = (engine) => {
    const own = line(engine);
    return Math.max(...own) < 0.1 || Math.min(...own) > 0.9 ? mixed(own, [0.5, 0.5, 0.5], 0.36) : own;
  };
  const line = (engine) => of(`--eng-${engine.slug}`);

  /** What is no engine's: ground, fixed bodies, shadows, edges. */
  const common = () => {
    const [paper, rule, strong, ink] = ["--panel", "--rule", "--strong-rule", "--ink"].map(of);
    return { paper, rule, ink, fixed: mixed(paper, strong, 0.55), shade: mixed(paper, strong, 0.3) };
  };

  return { solid, line, common, forget: () => known.clear() };
})();

const element = (tag, kind = "", text = "") => Object.assign(document.createElement(tag), { className: kind, textContent: text });
const seconds = (t) => `${t.toFixed(2)} s`;

"use strict";
(() => {
  const root = document.documentElement;
  const all = (selector) => Array.from(document.querySelectorAll(selector));
  root.classList.add("js");

  // Private windows and some file: pages have no storage; the switch then lasts as long as the page.
  const store = {
    get: (key) => { try { return localStorage.getItem(key); } catch { return null; } },
    set: (key, value) => { try { localStorage.setItem(key, value); } catch { /* nothing to keep it in */ } },
  };

  const themes = ["auto", "light", "dark"];
  const button = document.getElementById("theme");
  const show = (theme) => {
    if (theme === "auto") delete root.dataset.theme; else root.dataset.theme = theme;
    button.querySelector("span").textContent = theme;
    button.setAttribute("aria-label", "Theme: " + (theme === "auto" ? "as the system" : theme));
    button.dataset.theme = theme;
  };
  show(themes.includes(store.get("plumbline-theme")) ? store.get("plumbline-theme") : "auto");
  button.addEventListener("click", () => {
    const next = themes[(themes.indexOf(button.dataset.theme) + 1) % themes.length];
    show(next);
    document.dispatchEvent(new Event("plumbline:theme"));
    store.set("plumbline-theme", next);
  });

  const cells = all(".cell").map((element) => ({
    element, text: element.querySelector("summary").textContent.toLowerCase(), word: element.dataset.word,
  }));
  const filter = document.getElementById("filter");
  const state = document.getElementById("state");
  const found = document.getElementById("found");
  const sift = () => {
    const words = filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const cell of cells) {
      const hit = words.every((word) => cell.text.includes(word)) && (!state.value || cell.word === state.value);
      cell.element.hidden = !hit;
      shown += hit;
    }
    found.textContent = shown === cells.length ? `${shown} cells` : `${shown} of ${cells.length} cells`;
  };
  filter.addEventListener("input", sift);
  state.addEventListener("change", sift);
  filter.form.addEventListener("submit", (event) => event.preventDefault());

  for (const box of all("[data-engine]")) {
    const act = () => {
      root.classList.toggle("hide-" + box.dataset.engine, !box.checked);
      const on = all("[data-engine]").filter((one) => one.checked).length, of = all("[data-engine]").length;
      document.getElementById("amount").textContent = on === of ? of : `${on} of ${of}`;
      document.dispatchEvent(new Event("plumbline:engines"));
    };
    box.addEventListener("change", act);
    act();
  }
  const engines = document.querySelector(".engines");
  addEventListener("click", (event) => { if (engines && !engines.contains(event.target)) engines.open = false; });
  addEventListener("keydown", (event) => { if (event.key === "Escape" && engines) engines.open = false; });

  for (const copy of all(".copy")) {
    copy.addEventListener("click", async () => {
      const code = copy.previousElementSibling;
      try {
        await navigator.clipboard.writeText(code.textContent);
        copy.textContent = "copied";
      } catch {
        getSelection().selectAllChildren(code);
        copy.textContent = "selected";
      }
      setTimeout(() => { copy.textContent = "copy"; }, 1500);
    });
  }

  const open = () => {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const details = target && target.closest("details");
    if (!details) return;
    if (details.hidden) { filter.value = ""; state.value = ""; sift(); }
    details.open = true;
    target.scrollIntoView();
  };
  addEventListener("hashchange", open);
  open();

  let opened = [];
  addEventListener("beforeprint", () => {
    opened = all("#method details:not([open]), .fold:not([open])");
    opened.forEach((details) => { details.open = true; });
  });
  addEventListener("afterprint", () => opened.forEach((details) => { details.open = false; }));
  root.dataset.ready = "";
})();

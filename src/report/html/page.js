"use strict";
(() => {
  const frames = JSON.parse(document.getElementById("frames").textContent);
  const viewer = document.getElementById("viewer");
  if (!frames.length || !viewer) return;
  const stage = viewer.querySelector(".stage");
  const [a, b] = stage.querySelectorAll("img");
  const slider = viewer.querySelector("input[type=range]");
  const title = document.getElementById("frame-name");
  const modes = ["slider", "side", "flicker", "difference"];
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let at = 0;
  let mode = "slider";
  let timer = 0;

  function show(frame) {
    at = (frame + frames.length) % frames.length;
    const { name, words } = frames[at];
    a.src = frames[at].a;
    b.src = frames[at].b;
    a.alt = "A, " + name;
    b.alt = "B, " + name;
    title.textContent = name + (words ? " — " + words : "");
    for (const row of document.querySelectorAll("tr[data-frame]")) {
      row.setAttribute("aria-selected", String(Number(row.dataset.frame) === at));
    }
  }

  function look(next) {
    mode = next;
    stage.className = "stage " + mode;
    slider.disabled = mode !== "slider";
    for (const button of viewer.querySelectorAll("button[data-mode]")) {
      button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
    }
    clearInterval(timer);
    if (mode === "flicker" && !still) {
      timer = setInterval(() => stage.classList.toggle("first"), 500);
    }
  }

  slider.addEventListener("input", () => stage.style.setProperty("--at", slider.value + "%"));
  for (const button of viewer.querySelectorAll("button[data-mode]")) {
    button.addEventListener("click", () => look(button.dataset.mode));
  }
  viewer.querySelector("[data-step='-1']").addEventListener("click", () => show(at - 1));
  viewer.querySelector("[data-step='1']").addEventListener("click", () => show(at + 1));
  for (const row of document.querySelectorAll("tr[data-frame]")) {
    row.tabIndex = 0;
    const choose = () => show(Number(row.dataset.frame));
    row.addEventListener("click", choose);
    row.addEventListener("keydown", (event) => {
      if (event.key === "Enter") choose();
    });
  }
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // On the slider the arrows are the slider's.
    const arrows = event.target !== slider;
    const key = event.key;
    if (arrows && key === "ArrowLeft") show(at - 1);
    else if (arrows && key === "ArrowRight") show(at + 1);
    else if (key >= "1" && key <= "4") look(modes[Number(key) - 1]);
    else if (key === " " && mode === "flicker" && event.target === document.body) {
      stage.classList.toggle("first");
      event.preventDefault();
    }
  });
  const wanted = new URLSearchParams(location.hash.slice(1));
  show(Number(wanted.get("frame")) || 0);
  look(modes.includes(wanted.get("mode")) ? wanted.get("mode") : "slider");
})();

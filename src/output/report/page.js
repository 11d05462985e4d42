// Turns each level's empty .slider into a before/after view of pictures that are already on the page.
"use strict";
for (const slider of document.querySelectorAll(".slider")) {
  const level = slider.dataset.level;
  const picture = (id) => document.getElementById(id);
  const sources = {
    reference: [picture("reference"), "reference"],
    inverse: [picture("inverse-" + level), "inverse texture"],
    plain: [picture("plain-" + level), "plain LoD"],
  };
  if (Object.values(sources).some(([image]) => !image)) continue;
  const make = (tag, className, parent) => {
    const element = document.createElement(tag);
    element.className = className;
    return parent.appendChild(element);
  };
  const frame = make("div", "frame stage", slider);
  const first = make("img", "first", frame);
  const second = make("img", "second", frame);
  const left = make("span", "tag left", frame);
  const right = make("span", "tag right", frame);
  const range = make("input", "", slider);
  Object.assign(range, { type: "range", min: 0, max: 100, step: 0.1, value: 50 });
  range.setAttribute("aria-label", "Where the two pictures meet");
  const cut = () => frame.style.setProperty("--cut", range.value + "%");
  range.addEventListener("input", cut);
  const drag = (event) => {
    if (!event.buttons && event.type === "pointermove") return;
    const box = frame.getBoundingClientRect();
    range.value = (100 * (event.clientX - box.left)) / box.width;
    cut();
  };
  frame.addEventListener("pointerdown", drag);
  frame.addEventListener("pointermove", drag);
  const choices = make("div", "choices", slider);
  const show = (a, b, button) => {
    for (const [image, tag, name] of [[first, left, a], [second, right, b]]) {
      image.src = sources[name][0].src;
      image.alt = sources[name][0].alt;
      tag.textContent = sources[name][1];
    }
    for (const other of choices.children) other.setAttribute("aria-pressed", String(other === button));
  };
  for (const [a, b] of [["plain", "inverse"], ["inverse", "reference"], ["plain", "reference"]]) {
    const button = make("button", "", choices);
    button.type = "button";
    button.textContent = sources[a][1] + " | " + sources[b][1];
    button.addEventListener("click", () => show(a, b, button));
  }
  show("plain", "inverse", choices.children[0]);
  cut();
  slider.hidden = false;
}

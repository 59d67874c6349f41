// Puts a divider between two pictures of each gallery. Without this script, the pictures stand side by side.
"use strict";
const template = document.getElementById("compare-template");
for (const gallery of document.querySelectorAll("[data-compare]")) {
  const pictures = new Map();
  for (const figure of gallery.querySelectorAll("figure")) {
    if (!pictures.has(figure.dataset.name)) pictures.set(figure.dataset.name, figure.querySelector("img"));
  }
  if (pictures.size < 2) continue;
  const compare = template.content.cloneNode(true).firstElementChild;
  const stage = compare.querySelector(".stage");
  const range = compare.querySelector("input");
  const selects = [...compare.querySelectorAll("select")];
  const images = [...stage.querySelectorAll("img")];
  const move = () => {
    stage.style.setProperty("--at", range.value + "%");
    range.setAttribute("aria-valuetext", `${range.value} % ${selects[0].value}, then ${selects[1].value}`);
  };
  const choose = (side) => {
    const shown = pictures.get(selects[side].value);
    for (const name of ["src", "alt", "width", "height"]) images[side].setAttribute(name, shown.getAttribute(name));
    move();
  };
  const wanted = gallery.dataset.compare.split(",");
  selects.forEach((select, side) => {
    for (const name of pictures.keys()) select.add(new Option(name));
    select.value = pictures.has(wanted[side]) ? wanted[side] : [...pictures.keys()][side];
    select.addEventListener("change", () => choose(side));
  });
  range.addEventListener("input", move);
  choose(0);
  choose(1);
  gallery.querySelector("h3").after(compare);
}

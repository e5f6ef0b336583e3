/* data of the page, and its parts */
"use strict";

const data = JSON.parse(document.getElementById("page-data").textContent);
const KINDS = { f4: Float32Array, u2: Uint16Array, u4: Uint32Array, i2: Int16Array };
const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["sendDataToCloud", "lasso2d", "select2d"] };

function unpack(text, kind) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new KINDS[kind](bytes.buffer);
}

function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "onchange" || key === "onclick") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

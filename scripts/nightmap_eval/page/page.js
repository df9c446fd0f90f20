// SPDX-License-Identifier: Apache-2.0
// Opens sections that a link names, and all of them for print; buttons with data-copy copy their text.
"use strict";
const openTarget = () => {
  const target = location.hash ? document.getElementById(decodeURIComponent(location.hash.slice(1))) : null;
  for (let at = target; at; at = at.parentElement) if (at.tagName === "DETAILS") at.open = true;
  if (target) target.scrollIntoView();
};
addEventListener("hashchange", openTarget);
openTarget();
let closed = [];
addEventListener("beforeprint", () => {
  closed = [...document.querySelectorAll("details:not([open])")];
  for (const one of closed) one.open = true;
});
addEventListener("afterprint", () => { for (const one of closed) one.open = false; });

// The clipboard needs a secure page; one that is opened from disk may have none.
const copy = (text, button) => {
  const said = button.textContent;
  const tell = (word) => { button.textContent = word; setTimeout(() => { button.textContent = said; }, 1200); };
  const byHand = () => {
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    tell(document.execCommand("copy") ? "copied" : "cannot copy");
    area.remove();
  };
  if (navigator.clipboard) navigator.clipboard.writeText(text).then(() => tell("copied"), byHand);
  else byHand();
};
addEventListener("click", (event) => {
  const button = event.target.closest ? event.target.closest("button[data-copy]") : null;
  if (button) copy(button.dataset.copy, button);
});

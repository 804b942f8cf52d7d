// What the theme leaves to be done: frames as high as the boards in them, and names for what screen readers announce.
"use strict";

window.addEventListener("message", (event) => {
  const height = event.data?.episodeHeight;
  if (!Number.isFinite(height)) return;
  for (const frame of document.querySelectorAll("iframe.board")) {
    if (frame.contentWindow === event.source) frame.style.height = `${Math.ceil(height) + 2}px`; // with its border
  }
});

for (const frame of document.querySelectorAll("iframe.board")) frame.contentWindow.postMessage("height", "*"); // of those that told it before

function nameParts() {
  document.querySelector(".md-search")?.setAttribute("aria-label", "Search");
  document.querySelectorAll("nav.md-code__nav:not([aria-label])").forEach((nav) => {
    nav.setAttribute("aria-label", `Actions of code block ${[...document.querySelectorAll("pre > code")].indexOf(nav.closest("pre")?.querySelector("code")) + 1}`);
  });
}

document.addEventListener("DOMContentLoaded", () => {
  nameParts();
  new MutationObserver(nameParts).observe(document.body, { childList: true, subtree: true }); // the theme adds them when they are scrolled to
});

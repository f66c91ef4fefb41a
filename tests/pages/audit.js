// What a page must not have: words over words, words too pale to read, controls without a name, a page too wide.
() => {
  // A narrow window keeps a table's heads for screen readers alone.
  const unseen = (element) => { const head = element.closest("thead"); return head && getComputedStyle(head).position === "absolute"; };
  const seen = (element) => element.checkVisibility({ opacityProperty: true, visibilityProperty: true }) && !unseen(element);
  const boxes = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const holder = node.parentElement;
    const words = node.data.trim();
    if (!words || !holder || /^(script|style|title|option|noscript)$/i.test(holder.tagName) || !seen(holder)) continue;
    if (holder.closest("[aria-hidden=true], .unseen")) continue;
    range.selectNodeContents(node);
    for (const box of range.getClientRects()) {
      if (box.width < 2 || box.height < 2) continue;
      const clip = holder.closest(".scroll, figure, .panel3d, pre");
      const frame = clip ? clip.getBoundingClientRect() : null;
      if (frame && (box.left >= frame.right || box.right <= frame.left)) continue;
      boxes.push({ words, holder, left: box.left, right: box.right, top: box.top + scrollY, bottom: box.bottom + scrollY });
    }
  }
  boxes.sort((a, b) => a.top - b.top);
  const overlaps = [];
  for (let i = 0; i < boxes.length && overlaps.length < 10; i++) {
    for (let k = i + 1; k < boxes.length && boxes[k].top < boxes[i].bottom - 3; k++) {
      const a = boxes[i], b = boxes[k];
      if (a.holder === b.holder || a.holder.contains(b.holder) || b.holder.contains(a.holder)) continue;
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      // A line's box is a third higher than its letters.
      if (wide > 3 && high > 0.4 * Math.min(a.bottom - a.top, b.bottom - b.top)) overlaps.push([a.words, b.words, wide, high]);
    }
  }

  const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgba = (text) => {
    canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = "#000"; canvas.fillStyle = text; canvas.fillRect(0, 0, 1, 1);
    const d = canvas.getImageData(0, 0, 1, 1).data;
    return [d[0] / 255, d[1] / 255, d[2] / 255, d[3] / 255];
  };
  const luminance = (c) => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  const behind = (element) => {
    for (let up = element; up; up = up.parentElement) {
      const colour = rgba(getComputedStyle(up).backgroundColor);
      if (colour[3] > 0.99) return colour;
    }
    return rgba(matchMedia("(prefers-color-scheme: dark)").matches ? "#12171c" : "#fff");
  };
  const pale = new Map();
  for (const { words, holder } of boxes) {
    const inSvg = holder.closest("svg");
    if (inSvg && holder.getAttribute("fill") === "none") continue;  // a halo behind words
    const style = getComputedStyle(holder);
    const ink = rgba(inSvg ? style.fill : style.color);
    // Words in a cell of a map stand on the cell drawn just before them.
    const cell = holder.classList.contains("cell") && getComputedStyle(holder.previousElementSibling).fill;
    const paper = cell && cell !== "none" ? rgba(cell) : behind(inSvg || holder);
    const [a, b] = [luminance(ink), luminance(paper)].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.6 && style.fontWeight >= 700);
    if (ratio < (large ? 3 : 4.5) - 0.02 && pale.size < 10) pale.set(words.slice(0, 40), ratio);
  }

  const nameless = [...document.querySelectorAll("button, input, select, canvas, [role=slider], a[href]")]
    .filter((c) => seen(c) && !(c.getAttribute("aria-label") || c.getAttribute("aria-labelledby") || c.title
      || c.textContent.trim() || (c.labels && c.labels.length)))
    .map((c) => c.outerHTML.slice(0, 120));
  const cut = [...document.querySelectorAll("h1, h2, h3, p, li, td, th, button, label")]
    .filter((e) => seen(e) && e.scrollWidth > e.clientWidth + 2 && e.clientWidth > 0 && getComputedStyle(e).display !== "inline"
      && !e.querySelector("svg, pre, .scroll, figure"))
    .map((e) => e.textContent.trim().slice(0, 60));
  return {
    overlaps, pale: [...pale], nameless, cut,
    too_wide: document.documentElement.scrollWidth - innerWidth,
    opened: performance.getEntriesByType("navigation")[0].loadEventEnd,
  };
}

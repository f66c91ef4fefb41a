// What every page does: folds open for a link and for print, and tables name their cells where the window is narrow.
"use strict";
(function () {
  function reveal() {
    let name = "";
    try { name = decodeURIComponent(location.hash.slice(1)); } catch (error) { return; }
    const target = name && document.getElementById(name);
    if (!target) return;
    for (let up = target; up; up = up.parentElement) if (up.tagName === "DETAILS") up.open = true;
    target.scrollIntoView();
  }
  addEventListener("hashchange", reveal);
  document.addEventListener("click", function (event) {
    const link = event.target.closest && event.target.closest('a[href^="#"]');
    if (link && link.hash === location.hash) reveal();
  });
  reveal();
  addEventListener("beforeprint", function () {
    document.querySelectorAll("details").forEach(function (each) { each.open = true; });
  });

  // The heads of a table's columns, written to its cells: a narrow window shows a row as a card.
  document.querySelectorAll("table:not(.key)").forEach(function (table) {
    const head = table.tHead && table.tHead.rows.length === 1 ? table.tHead.rows[0] : null;
    if (!head) return;
    const names = [];
    for (const cell of head.cells) for (let k = 0; k < cell.colSpan; k++) names.push(cell.textContent.trim());
    for (const body of table.tBodies) {
      const held = [];  // rows that a cell above still covers, by column
      for (const row of body.rows) {
        let column = 0;
        for (const cell of row.cells) {
          while (held[column] > 0) held[column++]--;
          if (cell.colSpan > 1) cell.classList.add("across");
          if (!cell.textContent.trim() && !cell.firstElementChild) cell.classList.add("nothing");
          if (cell.colSpan === 1 && !cell.hasAttribute("data-label")) cell.dataset.label = names[column] || "";
          for (let k = 0; k < cell.colSpan; k++) held[column++] = cell.rowSpan - 1;
        }
        while (column < names.length) { if (held[column] > 0) held[column]--; column++; }
      }
    }
    table.classList.add("labelled");
  });
})();

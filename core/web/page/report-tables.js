// Sorts tables by a click on a column's header.

import { htmlNode } from "./dom.js";

/** Puts a button into each header, so that sorting works by keyboard, too. */
export function makeSortable(table) {
  const headers = [...table.tHead.rows[0].cells];
  headers.forEach((header, column) => {
    const button = htmlNode("button", { type: "button", class: "sort" }, header.textContent);
    header.replaceChildren(button);
    button.addEventListener("click", () => {
      // The first click sorts names from a to z, and values from the largest.
      const first = column === 0 ? "ascending" : "descending";
      const other = column === 0 ? "descending" : "ascending";
      const order = header.getAttribute("aria-sort") === first ? other : first;
      for (const each of headers) each.removeAttribute("aria-sort");
      header.setAttribute("aria-sort", order);
      sortRows(table.tBodies[0], column, order === "ascending" ? 1 : -1);
    });
  });
}

/** Sorts rows by a column; rows without a value come last in either order. */
function sortRows(body, column, sign) {
  const text = (row) => row.cells[column].textContent.trim();
  const figure = (row) => Number(text(row));
  const compare = (a, b) => {
    if (column === 0) return sign * text(a).localeCompare(text(b));
    const [one, other] = [figure(a), figure(b)];
    if (Number.isNaN(one) || Number.isNaN(other)) return Number.isNaN(one) - Number.isNaN(other);
    return sign * (one - other);
  };
  body.append(...[...body.rows].sort(compare));
}

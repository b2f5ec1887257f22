// A picture, large; a click or the space bar flips between ours and what is expected, at the same place.
const viewer = document.querySelector("dialog");
const [image, title] = [viewer.querySelector("img"), viewer.querySelector("b")];
let pictures = [], shown = 0;

function show(which) {
  shown = which;
  image.src = pictures[shown].src;
  image.alt = pictures[shown].alt;
  title.textContent = pictures[shown].alt;
}

// The difference, third, is left by the first flip.
const flip = () => show(shown === 0 && pictures.length > 1 ? 1 : 0);

for (const button of document.querySelectorAll("figure button")) {
  button.addEventListener("click", () => {
    pictures = [...button.closest(".pictures").querySelectorAll("img")];
    show(pictures.indexOf(button.querySelector("img")));
    viewer.showModal();
  });
}
image.addEventListener("click", flip);
viewer.addEventListener("click", (event) => event.target === viewer && viewer.close());
viewer.addEventListener("keydown", (event) => {
  const place = "123".indexOf(event.key);
  if (event.key === " ") { event.preventDefault(); flip(); }
  if (place >= 0 && pictures[place]) show(place);
});

// Who follows a link to a group wants to see what is in it.
addEventListener("hashchange", () => {
  const target = document.getElementById(location.hash.slice(1));
  if (target?.tagName === "DETAILS") target.open = true;
});

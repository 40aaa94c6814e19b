// Hands what came of a script over to the test that opened the page.
function hand_over(outcome) {
  const told = document.createElement("pre");
  told.id = "outcome";
  told.textContent = JSON.stringify(outcome).replace(/</g, "");
  document.body.append(told);
}

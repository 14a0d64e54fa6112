// The page where its address has no token, as of a service whose journal has none: it asks, refuses a wrong one, and opens.

import { expect, runBrowserTest, settled } from "./page.mjs";

const TOKEN = new URLSearchParams(new URL(process.argv[2]).hash.slice(1)).get("token");

await runBrowserTest(async ({ visit, picture }) => {
  const page = await visit("#session=main");
  const field = page.getByLabel("Token");
  await field.waitFor();
  expect((await page.getByRole("alert").count()) === 0, "Nothing is wrong before a token was tried.");
  await picture(page, "1-asked");

  await page.keyboard.type("0".repeat(32));
  await page.keyboard.press("Enter");
  await page.getByRole("alert").getByText("wrong").waitFor();
  await picture(page, "2-wrong");

  await page.keyboard.type(` ${TOKEN} `);
  await page.getByRole("button", { name: "Sign in" }).click();
  await settled(page);
  expect(!page.url().includes(TOKEN), "The address has no token, to be shown to nobody by accident.");
  await picture(page, "3-signed-in");
  await page.reload();
  await settled(page);

  // A wrong one in the address is put right in the same way.
  const wrong = await visit(`#token=${"1".repeat(32)}&session=main`);
  await wrong.getByRole("alert").waitFor();
  await wrong.getByLabel("Token").fill(TOKEN);
  await wrong.keyboard.press("Enter");
  await settled(wrong);
});

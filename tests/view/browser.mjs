// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A headless Chromium, and pages in it that remember what they complained about.
import {existsSync} from 'node:fs';
import {chromium} from 'playwright-core';

const PATHS = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser',
               '/usr/bin/google-chrome'];
const ARGUMENTS = ['--headless=new', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
                   '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', '--hide-scrollbars'];

/** @returns {Promise<import('playwright-core').Browser>} */
export async function startBrowser() {
  const executablePath = PATHS.find((path) => path && existsSync(path));
  if (!executablePath) throw new Error('no Chromium (Debian: chromium)');
  return chromium.launch({executablePath, args: ARGUMENTS});
}

/**
 * @param {import('playwright-core').Browser} browser
 * @param {string} url
 * @param {object} options  of a browser context
 * @returns {Promise<import('playwright-core').Page>}  with .complaints: errors and warnings of the
 *   console and of scripts, once the first frame has been drawn
 */
export async function openPage(browser, url, options = {}) {
  const context = await browser.newContext({viewport: {width: 1000, height: 560}, ...options});
  const page = await context.newPage();
  page.complaints = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type()) && !harmless(message.text())) {
      page.complaints.push(message.text());
    }
  });
  page.on('pageerror', (error) => page.complaints.push(String(error)));
  await page.goto(url, {timeout: 120000});
  await page.waitForFunction(() => window.tandemView?.drawn > 0, null, {timeout: 120000});
  return page;
}

/** Messages of the software renderer. */
const harmless = (text) => /GPU stall due to ReadPixels|GL Driver Message/.test(text);

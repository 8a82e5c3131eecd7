import { render } from 'preact';
import { App } from './app';
import { keepConnected } from './model/connection';
import { keepInformed } from './model/session';
import { Guard } from './parts/guard';

/** Without its style the page could not show that a value is old. */
function styleArrived(): boolean {
    return getComputedStyle(document.documentElement).getPropertyValue('--edge') !== '';
}

const page = document.getElementById('page');
if (page && !styleArrived()) {
    const text = document.createElement('p');
    text.textContent = 'Without its style this page cannot mark old values, so it shows none.';
    page.append(text);
} else if (page) {
    // The text about a page that could not be loaded goes only now.
    const app = document.createElement('div');
    app.id = 'app';
    page.replaceWith(app);
    render(<Guard><App /></Guard>, app);
    keepInformed();
    keepConnected();
}

// Entry point of the dashboard.
import { render } from 'preact';
import { App, startApp } from './app';
import { startLive } from './state/live';
import { followLinks } from './state/route';
import { followScenes } from './state/summaries';

followLinks();
startApp();
followScenes();
startLive();
render(<App />, document.getElementById('app')!);

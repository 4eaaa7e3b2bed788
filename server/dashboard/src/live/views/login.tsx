// Lets the reader in with a token. The page does not keep it: the daemon gives a cookie that no script can read.
import { useState } from 'preact/hooks';
import { hasLostLogin, login } from '../state/account';
import { asApiError } from '../transport/calls';

export function Login() {
  const [problem, setProblem] = useState('');
  const [isBusy, setBusy] = useState(false);
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    const token = String(new FormData(form).get('token')).trim();
    if (!token) return setProblem('Paste the token that you were given.');
    setBusy(true);
    try {
      await login(token);
    } catch (error) {
      setProblem(`${asApiError(error).message}.`);
    } finally {
      setBusy(false);
    }
  };
  return (
    <section class="login" aria-labelledby="login-heading">
      <h1 id="login-heading">Log in</h1>
      {hasLostLogin() && <p role="status">Your login has ended: its token did, or somebody logged out. Log in again, and the page goes on where it was.</p>}
      <p>This daemon shows what it knows to those who have a token. Whoever runs it makes one:</p>
      <pre>sweepstaked token create NAME --role watch</pre>
      <form onSubmit={(event) => void submit(event)}>
        <label for="token">Token</label>
        <input id="token" name="token" type="password" autocomplete="current-password" required spellcheck={false}
          aria-invalid={problem !== ''} aria-describedby="login-problem" />
        <button type="submit" class="primary" disabled={isBusy}>{isBusy ? 'Asking …' : 'Log in'}</button>
        <p id="login-problem" class="problem" role="alert">{problem}</p>
      </form>
    </section>
  );
}

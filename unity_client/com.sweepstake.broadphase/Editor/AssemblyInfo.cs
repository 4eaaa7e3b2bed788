using System.Runtime.CompilerServices;

[assembly: InternalsVisibleTo("Sweepstake.Unity.Tests")]
[assembly: InternalsVisibleTo("Sweepstake.Editor.Tests")]

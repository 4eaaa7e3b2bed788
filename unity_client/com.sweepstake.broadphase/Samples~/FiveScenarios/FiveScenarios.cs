#nullable enable
using System;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// The library's five scenarios with 10,000 boxes. Keys: 1 to 5 select a scenario, M toggles between AI Decides and Manual, B selects the next
    /// backend, up and down double and halve the number of boxes.
    /// </summary>
    [RequireComponent(typeof(ScenarioPlayer))]
    [RequireComponent(typeof(SweepstakeHud))]
    public sealed class FiveScenarios : MonoBehaviour
    {
        private const int MaxObjects = 100_000;

        [SerializeField]
        [Range(1, MaxObjects)]
        [Tooltip("Number of boxes.")]
        private int objectCount = 10_000;

        private ScenarioPlayer? player;
        private SweepstakeManager? manager;

        private void Start()
        {
            manager = GetComponent<SweepstakeManager>();
            player = GetComponent<ScenarioPlayer>();
            player.ObjectCount = objectCount;
        }

        private void Update()
        {
            int digit = SampleKeys.Digit();
            if (digit > 0)
                player!.Scenario = SweepstakeLibrary.Scenes[digit - 1];
            if (SampleKeys.Mode)
                manager!.Mode = manager.Mode == SessionMode.Ai ? SessionMode.Manual : SessionMode.Ai;
            if (SampleKeys.Backend && manager!.Session != null)
                manager.SelectBackend(manager.Backends[(manager.Session.ActiveArm + 1) % manager.Backends.Count]);
            if (SampleKeys.More)
                player!.ObjectCount = Math.Min(player.ObjectCount * 2, MaxObjects);
            if (SampleKeys.Fewer)
                player!.ObjectCount = Math.Max(player.ObjectCount / 2, 1);
        }
    }
}
